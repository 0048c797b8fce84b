"""Public classes and functions have docstrings, shapes of arrays and type hints."""

import ast
import inspect
import re
from importlib import import_module
from operator import attrgetter
from pathlib import Path

from tests.modules import PACKAGE, dotted, everywhere


def public(path: Path):
    """Yields the public classes, functions and methods of a file with their dotted names."""
    tree = ast.parse(path.read_text())
    kinds = (ast.FunctionDef, ast.ClassDef)
    for node in tree.body:
        if isinstance(node, kinds) and not node.name.startswith("_"):
            yield node.name, node
            for inner in node.body if isinstance(node, ast.ClassDef) else ():
                if isinstance(inner, kinds) and not inner.name.startswith("_"):
                    yield f"{node.name}.{inner.name}", inner


def docstring(path: Path, name: str, node: ast.AST) -> str:
    """Returns the docstring, for a method without one that of the overridden method."""
    own = ast.get_docstring(node)
    if own is None and isinstance(node, ast.FunctionDef) and "." in name:
        own = inspect.getdoc(attrgetter(name)(import_module(dotted(path))))
    return own or ""


@everywhere
def test_everything_public_has_a_docstring(path):
    tree = ast.parse(path.read_text())
    assert ast.get_docstring(tree) or path.name == "__main__.py"
    missing = [name for name, node in public(path) if not docstring(path, name, node)]
    assert not missing


SIZE = r"(?:`\w+`|\.\.\.|\w{1,6}\+?(?:(?: | [+-] |-)(?:\w{1,2}|rows|steps)\b)*)"
SHAPE = re.compile(rf"\((?:{SIZE}, )*{SIZE},(?: {SIZE})?\)")
"""Shape in a docstring: (3,), (n, n), (13 + 2 n,), (T, ...), (`SIZE`,)."""

ARRAY = re.compile(r"ndarray|Tensor")


def is_array(annotation: ast.expr | None) -> bool:
    return annotation is not None and bool(ARRAY.search(ast.unparse(annotation)))


def description(name: str, doc: str) -> str:
    """Returns the entry in `Args` or `Attributes`, or without one the whole docstring."""
    entry = rf"^( *)(?:\w+, )*{name}(?:, \w+)*: (.*(?:\n\1 +.*)*)"
    if match := re.search(entry, doc, re.MULTILINE):
        return f"{name}: {match[2]}"
    return doc if re.search(rf"\b{name}\b", doc) else ""


def has_shape(text: str) -> bool:
    """Returns True if the text has a shape, or refers to something that has one."""
    return bool(SHAPE.search(text) or re.search(r"\b[Aa]s\b.*(?:`|there)", text))


def arrays(path: Path):
    """Yields each public array: its owner, its name ("" for a result), and the docstring."""
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
        for function, doc in functions:
            for argument in [*function.args.args, *function.args.kwonlyargs]:
                if is_array(argument.annotation):
                    yield name, argument.arg, doc


def test_shapes_are_found():
    entries = "a, b: (3,) m,\n        and rad.\n    c: As `f` has it.\n    d: m."
    doc = f"Position x (3,) m.\n\nArgs:\n    {entries}"
    assert description("b", doc) == "b: (3,) m,\n        and rad."
    have = [has_shape(description(name, doc)) for name in "abcxde"]
    assert have == [True, True, True, True, False, False]
    for shape in ("(T, ...)", "(`SIZE`,)", "(35 + 4 k + k steps,)", "(m N, m N)", "(3+,)"):
        assert has_shape(shape)
    for other in ("(paper, eq. 2)", "(n)", "(thrust at first, thrust at the end)"):
        assert not has_shape(other)
    assert len(list(arrays(PACKAGE / "model" / "vehicle" / "state.py"))) > 6


@everywhere
def test_arrays_have_shapes(path):
    missing = [
        f"{where}: {name or 'result'}"
        for where, name, doc in arrays(path)
        if not has_shape(description(name, doc) if name else doc)
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
