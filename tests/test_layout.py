"""The house: storeys, sizes, and what every system says of itself."""

import ast
import inspect
import re
from importlib import import_module
from pathlib import Path

import pytest
from pydrake.systems.framework import LeafSystem

from tests.modules import MODULES, PACKAGE, dotted, everywhere, relative

STOREYS = {
    0: (
        "__init__",
        "compiled",
        "errors",
        "files",
        "fingerprint",
        "garbage",
        "inputs",
        "reference_kinds",
        "schema",
        "scenario",
        "scenario_edit",
        "scenario_file",
        "scenario_rules",
        "fault_kinds",
        "world",
        "scenario_yaml",
        "scratch",
        "threads",
        "wire",
        "wire_message",
        "urdf",
    ),
    1: ("model",),
    2: ("systems",),
    3: (
        "station",
        "coordinator",
        "remote_coordinator",
        "physics",
        "bare_plant",
        "open_loop",
        "sensors",
        "wind",
        "guidance",
        "replacements",
    ),
    4: (
        "simulate",
        "not_finite",
        "monitor",
        "recording",
        "flight_log",
        "events",
        "summary",
        "flight_folder",
        "run_folder",
        "reports",
        "graph",
        "gallery",
        "system_page",
        "docstring",
        "companion",
        "interrupts",
        "processes",
        "compare",
        "margin_search",
        "margins",
        "identify",
        "identify_report",
        "excitation",
        "learning",
        "sweep",
        "bench",
    ),
    5: ("commands", "cli", "__main__"),
}

MOST_LINES = 300


def storey(module: str) -> int:
    """Of `aerodrake.simulate`, `aerodrake.model.mpc` and so on."""
    name = (module.split(".") + ["__init__"])[1]
    found = [number for number, names in STOREYS.items() if name in names]
    assert len(found) == 1, f"{module} stands on no storey"
    return found[0]


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


def test_there_is_a_house():
    assert len(MODULES) > 30
    assert "aerodrake.model.mpc" in imports(PACKAGE / "coordinator.py")
    assert storey("aerodrake.model.mpc") == 1 and storey("aerodrake") == 0


@everywhere
def test_imports_go_strictly_downward(path):
    """On a storey of several pages these may know each other, as long as nobody goes in circles."""
    here = storey(dotted(path))
    for module in imports(path):
        if module.startswith("aerodrake"):
            assert storey(module) <= here, f"{dotted(path)} imports {module}"


def test_nobody_goes_in_circles():
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


def leaf_systems():
    for path in sorted((PACKAGE / "systems").glob("*.py")):
        for _, kind in inspect.getmembers(import_module(dotted(path)), inspect.isclass):
            if issubclass(kind, LeafSystem) and kind.__module__ == dotted(path):
                yield kind


@pytest.mark.parametrize("kind", list(leaf_systems()), ids=lambda kind: kind.__name__)
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


@pytest.mark.parametrize("path", sorted((PACKAGE / "systems").glob("*.py")), ids=relative)
def test_the_vehicle_has_the_size_its_file_says(path):
    """No number of joints, states or features is written into a system."""
    numbers = {
        node.value
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.Constant) and type(node.value) is int
    }
    assert not numbers & {24, 30, 25, 33}


def test_packaged_data_is_packaged():
    import tomllib

    project = tomllib.loads((PACKAGE.parent / "pyproject.toml").read_text())
    patterns = project["tool"]["setuptools"]["package-data"]["aerodrake"]
    packaged = {path for pattern in patterns for path in PACKAGE.glob(pattern)}
    data = {
        path
        for path in PACKAGE.rglob("*")
        if path.is_file() and path.suffix not in (".py", ".pyc") and "__pycache__" not in path.parts
    }
    assert data == {path for path in packaged if path.is_file()}
