"""The house: storeys, sizes, and what every system says of itself."""

import ast
import inspect
import re
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.modules import MODULES, PACKAGE, SYSTEMS, dotted, everywhere

ROOMS = (
    "support",
    "scenario",
    "model",
    "systems",
    "wiring",
    "coordinator",
    "station",
    "wire",
    "gallery",
    "flight",
    "reports",
    "analysis",
    "identification",
    "learning",
    "mounting",
    "comparison",
    "sweeps",
    "budgets",
    "bench",
    "api",
    "commands",
    "cli",
    "__main__",
)
"""Folders and loose files of the package, from the ground up; each imports from those before it."""

MODEL_ROOMS = (
    "vehicle",
    "mujoco",
    "reference",
    "sensing",
    "low_level",
    "equivalent",
    "setpoint",
    "actuation",
    "qp",
    "mpc",
    "residual",
    "supervision",
)
"""Folders of `model`, likewise."""

LOOSE = {"__init__", "__main__", "cli", "coordinator", "station"}

MOST_LINES = 300

TESTS = [
    path.relative_to(Path(__file__).parent)
    for path in sorted(Path(__file__).parent.glob("*/**/test_*.py"))
    if "benchmarks" not in path.parts
]
"""Test files below `tests/` in a folder of their own, relative to it."""


def height(module: str) -> tuple[int, int]:
    """Position in `ROOMS`, and for a module of `model` in `MODEL_ROOMS`; -1 for a folder's own."""
    _, *parts = module.split(".")
    if not parts:
        return -1, -1
    in_model = parts[0] == "model" and len(parts) > 1
    return ROOMS.index(parts[0]), MODEL_ROOMS.index(parts[1]) if in_model else -1


def imports(path: Path) -> set[str]:
    """Every module it imports, wherever in the file."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path} imports relatively"
            found.add(node.module)
            if node.module == "aerodrake" or node.module == "pydrake":
                found |= {f"{node.module}.{alias.name}" for alias in node.names}
    return found


def test_the_package_is_found():
    assert len(MODULES) > 30
    assert "aerodrake.model.mpc.formulation" in imports(PACKAGE / "coordinator.py")
    assert height("aerodrake.model.mpc.formulation") > height("aerodrake.model.vehicle")


def test_rooms_are_folders():
    assert {path.stem for path in PACKAGE.glob("*.py")} == LOOSE
    code = {path.relative_to(PACKAGE).parts[0] for path in MODULES if path.parent != PACKAGE}
    assert code | LOOSE - {"__init__"} == set(ROOMS)
    inner = {path.name for path in (PACKAGE / "model").iterdir() if any(path.glob("*.py"))}
    assert inner == set(MODEL_ROOMS)


def test_contributing_shows_the_rooms_from_the_top_down():
    page = (PACKAGE.parent / "diagrams" / "contributing.md").read_text()
    tree = re.search(r"^```text\naerodrake/\n(.*?)^diagrams/", page, re.MULTILINE | re.DOTALL)[1]
    shown = [name for line in tree.splitlines() for name in line.strip().split("  ")[0].split()]
    data = {"scenarios/", "robots/", "networks/"}
    rooms = [name.removesuffix("/").removesuffix(".py") for name in shown if name not in data]
    assert tuple(reversed(rooms)) == ROOMS


@everywhere
def test_imports_go_strictly_downward(path):
    """Within a room modules import each other, but see `test_no_import_cycle`."""
    here = height(dotted(path))
    for module in imports(path):
        if module.startswith("aerodrake"):
            assert height(module) <= here, f"{dotted(path)} imports {module}"


def test_no_import_cycle():
    names = {dotted(path) for path in MODULES}
    below = {dotted(path): imports(path) & names for path in MODULES}
    while free := {name for name, others in below.items() if not others & set(below)}:
        below = {name: others for name, others in below.items() if name not in free}
    assert not below


@everywhere
def test_imports_name_exact_modules(path):
    modules = imports(path)
    assert not modules & {"pydrake", "pydrake.all"}
    if dotted(path).startswith("aerodrake.model"):
        assert not any(module.startswith("pydrake.systems") for module in modules)


@everywhere
def test_one_noun_per_file(path):
    lines = len(path.read_text().splitlines())
    assert lines <= MOST_LINES


def test_files_of_tests_are_as_short():
    paths = Path(__file__).parent.rglob("*.py")
    lengths = {path.name: len(path.read_text().splitlines()) for path in paths}
    assert [name for name, length in lengths.items() if length > MOST_LINES] == []


def definitions(path: Path) -> Iterator[ast.ClassDef | ast.FunctionDef]:
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ClassDef | ast.FunctionDef):
            yield node


def test_no_class_name_twice():
    names = [n.name for path in MODULES for n in definitions(path) if isinstance(n, ast.ClassDef)]
    assert len(names) > 100
    assert not [name for name, count in Counter(names).items() if count > 1]


@everywhere
def test_functions_can_be_held_in_mind(path):
    for node in definitions(path):
        if isinstance(node, ast.FunctionDef):
            arguments = [a.arg for a in (*node.args.posonlyargs, *node.args.args)]
            assert len([a for a in arguments if a not in ("self", "cls")]) <= 6, node.name
            body = node.body[1:] if ast.get_docstring(node) and node.body[1:] else node.body
            assert body[-1].end_lineno - body[0].lineno < 60, node.name


@everywhere
def test_docstrings_are_sentences_about_their_subject(path):
    oblique = re.compile(r"(What|Whether|Where|How|Of|That|Those)\b")
    for node in (ast.parse(path.read_text()), *definitions(path)):
        assert not oblique.match(ast.get_docstring(node) or ""), getattr(node, "name", path)


@pytest.mark.parametrize("kind", SYSTEMS, ids=lambda kind: kind.__name__)
def test_systems_say_their_ports_and_rate(kind):
    doc = inspect.getdoc(kind)
    assert "\nPorts:\n" in doc
    assert re.search(r"^(State, rate|Rate):", doc, re.MULTILINE)
    source = inspect.getsource(kind)
    stated = set(re.findall(r"\w+", doc))
    for name in re.findall(r'Declare\w*Port\(\s*"(\w+)"', source):
        assert name in stated, f"port {name} is not in the docstring"
    if "Declare" in source and "State(" in source:
        assert re.search(r"^State\b.*:", doc, re.MULTILINE)


@pytest.mark.parametrize("kind", SYSTEMS, ids=lambda kind: kind.__name__)
def test_the_vehicle_has_the_size_its_file_says(kind):
    """No number of joints, states or features is written into a system."""
    numbers = {
        node.value
        for node in ast.walk(ast.parse(inspect.getsource(inspect.getmodule(kind))))
        if isinstance(node, ast.Constant) and type(node.value) is int
    }
    assert not numbers & {24, 30, 25, 33}


def test_the_link_over_lcm_is_an_option():
    """Without `aerodrake.wire`, only the flight, the commands and the gallery would change."""
    users = {
        path.relative_to(PACKAGE).as_posix()
        for path in PACKAGE.rglob("*.py")
        if any(module.startswith("aerodrake.wire.") for module in imports(path))
    }
    users = {user for user in users if not user.startswith("wire/")}
    gallery = {"gallery/loops.py", "gallery/system_page.py"}
    assert users == {"flight/simulate.py", "api/fly.py", "commands/coordinator.py"} | gallery


@pytest.mark.parametrize("path", TESTS, ids=str)
def test_tests_mirror_the_rooms(path):
    """Tests of a module begin with its name; those of several modules are one room higher."""
    modules = {module.stem for module in (PACKAGE / path.parent).glob("*.py")}
    name = path.stem.removeprefix("test_")
    assert any(name == module or name.startswith(f"{module}_") for module in modules)
