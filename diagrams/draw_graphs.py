"""Draws the closed loop, and every diagram and system in it, into diagrams/graphs.

The same as `aerodrake graph --out diagrams/graphs`; start here to draw a diagram
of your own.
"""

from pathlib import Path

from aerodrake.gallery import export_all
from aerodrake.scenario import Scenario
from aerodrake.station import make_closed_loop


def main() -> None:
    closed_loop = make_closed_loop(Scenario())
    for path in export_all(closed_loop, [], Path(__file__).parent / "graphs", depth=2):
        print(path)


if __name__ == "__main__":
    main()
