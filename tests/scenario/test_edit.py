"""Edits of scenario files change only the numbers."""

import os

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from aerodrake.scenario.edit import check_replaceable, replace_numbers
from aerodrake.scenario.load import packaged_scenarios
from aerodrake.support.errors import BadInput

KEY = "model.k_b"
NEW = (2.46, 3.0, 0.5)

LAYOUTS = {
    "flow": ("# a: b\nmodel:\n  k_b: [1, 2.50, 3e0] # why: k_b\n", "[2.46, 3.0, 0.5] # why"),
    "nested flow": ("{model: {k_b: [1,2,3], kind: paper}}", "k_b: [2.46,3.0,0.5], kind"),
    "block": (
        "model:\n  k_b:\n  - 1 # x\n  # of y\n  - 2\n\n  - 3\nseed: 1\n",
        "k_b:\n  - 2.46 # x\n  # of y\n  - 3.0\n\n  - 0.5\nseed: 1\n",
    ),
    "lines": (
        "model:\n  k_b: [1,\n    2, # y\n    3,\n  ]\n",
        "[2.46,\n    3.0, # y\n    0.5,\n  ]",
    ),
    "windows": ("model:\r\n  k_b: [1, 2, 3]\r\n# ü\r\n", "k_b: [2.46, 3.0, 0.5]\r\n# ü\r\n"),
    "wide characters before it": (
        "name: ü𝄞\nmodel:\n  k_b: [1, 2, 3]",
        "name: ü𝄞\nmodel:\n  k_b: [2.46",
    ),
    "byte order mark": ("\ufeffmodel:\n  k_b: [1, 2, 3]", "\ufeffmodel:\n  k_b: [2.46, 3.0, 0.5]"),
    "quoted": ("model: {'k_b': ['1', \"2\", 3]}\n", "'k_b': [2.46, 3.0, 0.5]"),
    "another k_b first": (
        "mpc:\n  k_b: [1, 2, 3]\nmodel:\n  k_e: [1, 2, 3]\n  k_b: [1, 2, 3]\n",
        "mpc:\n  k_b: [1, 2, 3]\nmodel:\n  k_e: [1, 2, 3]\n  k_b: [2.46, 3.0, 0.5]\n",
    ),
}


def written(path) -> dict[str, bytes]:
    return {p.name: p.read_bytes() for p in path.iterdir()}


@pytest.mark.parametrize(("before", "expected"), LAYOUTS.values(), ids=LAYOUTS)
def test_layout_and_comments_are_preserved(before, expected, tmp_path):
    path = tmp_path / "a.yaml"
    path.write_bytes(before.encode())
    check_replaceable(path, KEY)
    replace_numbers(path, KEY, NEW)
    after = path.read_bytes().decode()
    assert expected in after
    data = yaml.safe_load(before)
    data["model"]["k_b"] = list(NEW)
    assert yaml.safe_load(after) == data
    assert list(written(tmp_path)) == ["a.yaml"]


@pytest.mark.parametrize("name", ["clover_paper", "moving_target_paper"])
@given(numbers=st.tuples(*[st.floats(0.01, 50)] * 3))
def test_packaged_files_differ_in_that_line_only(name, numbers, tmp_path_factory):
    before = packaged_scenarios()[name].read_bytes()
    path = tmp_path_factory.mktemp("edit") / "a.yaml"
    path.write_bytes(before)
    replace_numbers(path, KEY, numbers)
    after = path.read_bytes()
    assert yaml.safe_load(after)["model"]["k_b"] == pytest.approx(numbers, rel=1e-15)
    lines = zip(before.splitlines(True), after.splitlines(True), strict=True)
    assert all(a == b or b.startswith(b"  k_b: [") for a, b in lines)
    replace_numbers(path, KEY, yaml.safe_load(before)["model"]["k_b"])
    assert path.read_bytes() == before


@pytest.mark.parametrize(
    "text",
    [
        "seed: 1\n",
        "model: {kind: paper}\n",
        "model: 3\n",
        "model:\n",
        "model: {k_b: 3}\n",
        "k_b: [1]\n",
    ],
)
@pytest.mark.parametrize("act", [lambda *a: replace_numbers(*a, NEW), check_replaceable])
def test_a_file_without_the_key_is_unchanged(text, act, tmp_path):
    path = tmp_path / "a.yaml"
    path.write_text(text)
    with pytest.raises(BadInput, match="a.yaml: model.k_b: expected this key in the file"):
        act(path, KEY)
    assert written(tmp_path) == {"a.yaml": text.encode()}


@pytest.mark.parametrize("failing", ["replace", "chmod"])
def test_a_failing_disk_leaves_the_file_unchanged(failing, tmp_path, monkeypatch):
    path = tmp_path / "a.yaml"
    path.write_text("model: {k_b: [1, 2, 3]}")

    def fail(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, failing, fail)
    with pytest.raises(BadInput, match="a.yaml: cannot be written: No space left on device$"):
        replace_numbers(path, KEY, NEW)
    assert written(tmp_path) == {"a.yaml": b"model: {k_b: [1, 2, 3]}"}


@pytest.mark.parametrize("protected", ["a.yaml", "."])
def test_a_protected_file_is_refused_in_advance(protected, tmp_path, monkeypatch):
    path = tmp_path / "a.yaml"
    path.write_text("model: {k_b: [1, 2, 3]}")
    read_only = (tmp_path / protected).resolve()
    monkeypatch.setattr(os, "access", lambda path, mode: path != read_only)
    with pytest.raises(BadInput, match="cannot be written: Permission denied$"):
        check_replaceable(path, KEY)


def test_links_and_permissions_are_preserved(tmp_path):
    path, link = tmp_path / "a.yaml", tmp_path / "link.yaml"
    path.write_text("model: {k_b: [1, 2, 3]}")
    path.chmod(0o640)
    link.symlink_to("a.yaml")
    replace_numbers(link, KEY, NEW)
    assert link.is_symlink() and path.stat().st_mode & 0o777 == 0o640
    assert path.read_text() == "model: {k_b: [2.46, 3.0, 0.5]}"
