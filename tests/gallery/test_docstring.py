"""The parser of docstrings."""

from aerodrake.gallery.docstring import Docstring


class Example:
    """An example.

    And more
    of it.

    Ports:
        in `a` (3), `b` (2 n): m, of something
            on a second line.
        in `c` (abstract): a `Thing (of sorts)`: with a colon.
        out `d` (nx). It feeds through.
        `a` may be left unconnected.
    State, rate: none.

    After all sections.

    Args:
        a: Not a port.
    """


def test_paragraphs_are_outside_of_sections():
    parsed = Docstring.of(Example)
    assert parsed.text == "An example.\n\nAnd more\nof it.\n\nAfter all sections."
    assert parsed.sections["State, rate"] == "none."
    assert parsed.sections["Args"] == "a: Not a port."
    assert parsed.sections["Ports"].startswith("in `a` (3), `b` (2 n): m, of something\n    on")


def test_each_port_has_its_meaning():
    assert Docstring.of(Example).ports == {
        ("in", "a"): "m, of something on a second line.",
        ("in", "b"): "m, of something on a second line.",
        ("in", "c"): "a `Thing (of sorts)`: with a colon.",
        ("out", "d"): "It feeds through.",
    }


def test_a_missing_docstring_is_empty():
    assert Docstring.of(None).ports == Docstring.of(type("Silent", (), {})).ports == {}
