"""The notebook runs, and its saved output is up to date."""

import re
import shutil
from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

DIAGRAMS = Path(__file__).parents[1] / "diagrams"


@pytest.fixture(scope="module")
def printed(tmp_path_factory) -> str:
    """Output of all cells, run in a copy of the folder."""
    folder = tmp_path_factory.mktemp("notebook") / "diagrams"
    shutil.copytree(DIAGRAMS, folder)
    notebook = nbformat.read(folder / "bring_your_own.ipynb", as_version=4)
    nbformat.validate(notebook)
    client = NotebookClient(notebook, timeout=300, resources={"metadata": {"path": str(folder)}})
    client.execute()
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", ())]
    assert sum("image/png" in output.get("data", ()) for output in outputs) == 4
    return "".join(output.get("text", "") for output in outputs)


def test_flights_and_systems(printed):
    assert re.search(r"^completed 0\.0\d\d mm$", printed, re.MULTILINE)
    assert "6 rotors" in printed and "adjustment gamma" in printed
    without, own = map(float, re.findall(r"([\d.]+) mm$", printed, re.MULTILINE)[1:])
    assert own < 0.8 * without


def test_the_saved_output_is_up_to_date(printed):
    notebook = nbformat.read(DIAGRAMS / "bring_your_own.ipynb", as_version=4)
    saved = [output for cell in notebook.cells for output in cell.get("outputs", ())]
    assert "".join(output.get("text", "") for output in saved) == printed
