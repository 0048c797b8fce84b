"""Draws every diagram and system, with a page for each, into diagrams/graphs.

It is the same as `aerodrake graph --out diagrams/graphs`. For a diagram of your own, pass
`aerodrake.gallery.graph.systems_by_name(diagram)`.
"""

from pathlib import Path

from aerodrake.gallery.export import export_all, gallery


def main() -> None:
    for path in export_all(gallery(), [], Path(__file__).parent / "graphs", depth=2):
        print(path)


if __name__ == "__main__":
    main()
