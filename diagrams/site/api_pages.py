"""Pages of the API reference: one for each folder of the package, from its docstrings."""

import ast
import inspect
from collections.abc import Iterator
from pathlib import Path

from sphinx.application import Sphinx
from sphinx.util.logging import getLogger

import aerodrake

ROOT = Path(__file__).parents[2]

LOGGER = getLogger(__name__)

STOREYS = {
    "5 · Commands": ("commands", "api"),
    "4 · Studies and reports": (
        "budgets",
        "sweeps",
        "comparison",
        "bench",
        "identification",
        "learning",
        "mounting",
        "analysis",
        "reports",
        "flight",
        "wire",
        "gallery",
    ),
    "3 · Wiring": ("wiring",),
    "2 · Systems": ("systems", "systems.faults"),
    "1 · Equations": (
        "model.vehicle",
        "model.mujoco",
        "model.reference",
        "model.sensing",
        "model.low_level",
        "model.equivalent",
        "model.setpoint",
        "model.actuation",
        "model.mpc",
        "model.qp",
        "model.residual",
        "model.supervision",
    ),
    "0 · Scenarios and support": ("scenario", "support"),
}
"""Folders of the package by storey, uppermost first."""

LOOSE = {"5 · Commands": ("cli",), "3 · Wiring": ("station", "coordinator")}
"""Modules of the package itself, each with a page of its own, by storey."""


def setup(app: Sphinx) -> dict[str, bool]:
    """Writes the pages before Sphinx looks for its sources."""
    app.connect("builder-inited", write_pages)
    app.connect("env-check-consistency", check_documented)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def write_pages(app: Sphinx) -> None:
    """Writes `api/`, which git ignores; unchanged pages are left, so that builds are short."""
    folder = Path(app.srcdir, "api")
    folder.mkdir(exist_ok=True)
    pages = {"index": index()}
    for storey, names in STOREYS.items():
        pages |= {name: page(name, modules_of(name)) for name in names}
        pages |= {name: page(name, []) for name in LOOSE.get(storey, ())}
    for name, text in pages.items():
        write_if_changed(folder / f"{name}.md", text)


def write_if_changed(path: Path, text: str) -> None:
    """Writes a file, unless it has this text."""
    if not path.exists() or path.read_text() != text:
        path.write_text(text)


def modules_of(folder: str) -> list[str]:
    """Returns the names of the modules of a folder, which is dotted."""
    files = (ROOT / "aerodrake" / folder.replace(".", "/")).glob("*.py")
    return sorted(file.stem for file in files if not file.stem.startswith("_"))


def index() -> str:
    """Returns the page of the storeys."""
    text = "# Reference to the package\n\n`import aerodrake` offers these names:\n\n"
    text += "| name | |\n|---|---|\n" + "".join(front_door()) + "\n"
    text += "The folders of the package are storeys, uppermost first. Each imports only from those "
    text += "below it.\n\n"
    for storey, names in STOREYS.items():
        entries = "\n".join([*LOOSE.get(storey, ()), *names])
        text += f"```{{toctree}}\n:maxdepth: 1\n:caption: {storey}\n\n{entries}\n```\n\n"
    return text


def front_door() -> Iterator[str]:
    """Yields a row of each public name of `aerodrake`, which leads to where it is defined."""
    for name in sorted(set(aerodrake.__all__) - {"__version__"}):
        thing = getattr(aerodrake, name)
        summary = inspect.getdoc(thing).splitlines()[0]
        yield f"| {{py:obj}}`{name} <{thing.__module__}.{thing.__qualname__}>` | {summary} |\n"


def page(name: str, modules: list[str]) -> str:
    """Returns the page of a folder, or of a module of the package, with its modules."""
    text = f"# {name}\n\n{automodule(f'aerodrake.{name}')}"
    for module in modules:
        text += f"\n## {module}\n\n{automodule(f'aerodrake.{name}.{module}')}"
    return text


def automodule(name: str) -> str:
    shown = "   :show-inheritance:\n" if name.startswith("aerodrake.systems") else ""
    return f"```{{eval-rst}}\n.. automodule:: {name}\n   :members:\n{shown}```\n"


def check_documented(app: Sphinx, env) -> None:
    """Warns of public classes and functions of the package that are not in the reference."""
    documented = set(env.domains["py"].objects)
    missing = []
    for file in sorted((ROOT / "aerodrake").rglob("*.py")):
        parts = file.relative_to(ROOT).with_suffix("").parts
        module = ".".join(part for part in parts if part != "__init__")
        names = [
            f"{module}.{node.name}"
            for node in ast.parse(file.read_text()).body
            if isinstance(node, ast.FunctionDef | ast.ClassDef) and not node.name.startswith("_")
        ]
        missing += [name for name in names if name not in documented]
    for name in missing:
        LOGGER.warning("%s is not in the API reference", name)
