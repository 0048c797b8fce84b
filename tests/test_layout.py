"""The house: storeys, sizes, and what every page says of itself."""

import ast
import inspect
import re
from importlib import import_module
from operator import attrgetter
from pathlib import Path

import pytest
from pydrake.systems.framework import LeafSystem

import aerodrake

PACKAGE = Path(aerodrake.__file__).parent

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

MODULES = sorted(PACKAGE.rglob("*.py"))


def relative(path: Path) -> str:
    return str(path.relative_to(PACKAGE))


def dotted(path: Path) -> str:
    parts = ["aerodrake", *path.relative_to(PACKAGE).with_suffix("").parts]
    return ".".join(part for part in parts if part != "__init__")


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


everywhere = pytest.mark.parametrize("path", MODULES, ids=relative)


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


def public(path: Path):
    """The public classes, functions and methods of a file, with their dotted names."""
    tree = ast.parse(path.read_text())
    kinds = (ast.FunctionDef, ast.ClassDef)
    for node in tree.body:
        if isinstance(node, kinds) and not node.name.startswith("_"):
            yield node.name, node
            for inner in node.body if isinstance(node, ast.ClassDef) else ():
                if isinstance(inner, kinds) and not inner.name.startswith("_"):
                    yield f"{node.name}.{inner.name}", inner


def docstring(path: Path, name: str, node: ast.AST) -> str:
    """Its own, or where a method has none that of the one it overrides."""
    own = ast.get_docstring(node)
    if own is None and isinstance(node, ast.FunctionDef) and "." in name:
        own = inspect.getdoc(attrgetter(name)(import_module(dotted(path))))
    return own or ""


@everywhere
def test_everything_public_says_what_it_is(path):
    tree = ast.parse(path.read_text())
    assert ast.get_docstring(tree) or path.name == "__main__.py"
    missing = [name for name, node in public(path) if not docstring(path, name, node)]
    assert not missing


SIZE = r"(?:`\w+`|\.\.\.|\w{1,6}\+?(?:(?: | [+-] |-)(?:\w{1,2}|rows|steps)\b)*)"
SHAPE = re.compile(rf"\((?:{SIZE}, )*{SIZE},(?: {SIZE})?\)")
"""A shape as docstrings write it: (3,), (n, n), (13 + 2 n,), (T, ...), (`SIZE`,)."""

ARRAY = re.compile(r"ndarray|Tensor")


def is_array(annotation: ast.expr | None) -> bool:
    return annotation is not None and bool(ARRAY.search(ast.unparse(annotation)))


def said_of(name: str, doc: str) -> str:
    """Its entry of `Args` or `Attributes`; where it has none, all of the docstring."""
    entry = rf"^( *)(?:\w+, )*{name}(?:, \w+)*: (.*(?:\n\1 +.*)*)"
    if match := re.search(entry, doc, re.MULTILINE):
        return f"{name}: {match[2]}"
    return doc if re.search(rf"\b{name}\b", doc) else ""


def has_shape(text: str) -> bool:
    """Itself, or by naming what has it."""
    return bool(SHAPE.search(text) or re.search(r"\b[Aa]s\b.*(?:`|there)", text))


def arrays(path: Path):
    """Each public array: where, its own name ("" for a result), and the docstring to say it."""
    for name, node in public(path):
        doc = docstring(path, name, node)
        if isinstance(node, ast.FunctionDef):
            functions = [(node, doc)]
            if is_array(node.returns):
                yield name, "", doc
        else:
            inner = [n for n in node.body if isinstance(n, ast.FunctionDef)]
            functions = [
                (n, f"{doc}\n{ast.get_docstring(n) or ''}") for n in inner if n.name == "__init__"
            ]
            fields = [n for n in node.body if isinstance(n, ast.AnnAssign)]
            for field in fields:
                if is_array(field.annotation) and not field.target.id.startswith("_"):
                    yield name, field.target.id, doc
        for function, said in functions:
            for argument in [*function.args.args, *function.args.kwonlyargs]:
                if is_array(argument.annotation):
                    yield name, argument.arg, said


def test_shapes_are_found():
    entries = "a, b: (3,) m,\n        and rad.\n    c: As `f` has it.\n    d: m."
    said = f"Of x (3,) m.\n\nArgs:\n    {entries}"
    assert said_of("b", said) == "b: (3,) m,\n        and rad."
    have = [has_shape(said_of(name, said)) for name in "abcxde"]
    assert have == [True, True, True, True, False, False]
    for shape in ("(T, ...)", "(`SIZE`,)", "(35 + 4 k + k steps,)", "(m N, m N)", "(3+,)"):
        assert has_shape(shape)
    for other in ("(paper, eq. 2)", "(n)", "(thrust at first, thrust at the end)"):
        assert not has_shape(other)
    assert len(list(arrays(PACKAGE / "model" / "vehicle_state.py"))) > 6


@everywhere
def test_arrays_say_their_shapes(path):
    missing = [
        f"{where}: {name or 'its result'}"
        for where, name, doc in arrays(path)
        if not has_shape(said_of(name, doc) if name else doc)
    ]
    assert not missing


@everywhere
def test_arguments_and_results_are_typed(path):
    for name, node in public(path):
        if isinstance(node, ast.FunctionDef):
            arguments = [*node.args.args, *node.args.kwonlyargs]
            bare = [a.arg for a in arguments if a.annotation is None]
            assert set(bare) <= {"self", "cls"}, name
            assert node.returns is not None, name


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
