"""The notebook runs from top to bottom, and finds what it says."""

import re
import shutil
from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

DIAGRAMS = Path(__file__).parents[1] / "diagrams"


@pytest.fixture(scope="module")
def printed(tmp_path_factory) -> str:
    """What its cells print, run in a copy of its folder."""
    folder = tmp_path_factory.mktemp("notebook") / "diagrams"
    shutil.copytree(DIAGRAMS, folder)
    notebook = nbformat.read(folder / "bring_your_own.ipynb", as_version=4)
    nbformat.validate(notebook)
    client = NotebookClient(notebook, timeout=300, resources={"metadata": {"path": str(folder)}})
    client.execute()
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", ())]
    assert sum("image/png" in output.get("data", ()) for output in outputs) == 4
    return "".join(output.get("text", "") for output in outputs)


def test_flights_and_systems_are_what_it_says(printed):
    assert re.search(r"^completed 0\.0\d\d mm$", printed, re.MULTILINE)
    assert "6 rotors" in printed and "adjustment gamma" in printed
    without, own = map(float, re.findall(r"([\d.]+) mm$", printed, re.MULTILINE)[1:])
    assert own < 0.8 * without


def test_it_is_shown_with_what_it_prints(printed):
    notebook = nbformat.read(DIAGRAMS / "bring_your_own.ipynb", as_version=4)
    shown = [output for cell in notebook.cells for output in cell.get("outputs", ())]
    assert "".join(output.get("text", "") for output in shown) == printed
