"""Draws every diagram and system, with a page for each, into diagrams/graphs.

It is the same as `aerodrake graph --out diagrams/graphs`. A diagram of your own can be given
instead: `aerodrake.graph(diagram)`.
"""

from pathlib import Path

import aerodrake


def main() -> None:
    for path in aerodrake.graph(out=Path(__file__).parent / "graphs"):
        print(path)


if __name__ == "__main__":
    main()
