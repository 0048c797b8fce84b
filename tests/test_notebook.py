"""The notebook runs, and its saved output is up to date."""

import re
import shutil
from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

DIAGRAMS = Path(__file__).parents[1] / "diagrams"


def read(folder: Path) -> nbformat.NotebookNode:
    notebook = nbformat.read(folder / "bring_your_own.ipynb", as_version=4)
    nbformat.validate(notebook)
    return notebook


def outputs(notebook: nbformat.NotebookNode) -> list[nbformat.NotebookNode]:
    return [output for cell in notebook.cells for output in cell.get("outputs", ())]


def text(notebook: nbformat.NotebookNode) -> str:
    return "".join(output.get("text", "") for output in outputs(notebook))


@pytest.fixture(scope="module")
def notebook(tmp_path_factory) -> nbformat.NotebookNode:
    """The notebook, run in a copy of the folder."""
    folder = tmp_path_factory.mktemp("notebook") / "diagrams"
    shutil.copytree(DIAGRAMS, folder)
    notebook = read(folder)
    client = NotebookClient(notebook, timeout=300, resources={"metadata": {"path": str(folder)}})
    client.execute()
    return notebook


def test_flights_and_systems(notebook):
    printed = text(notebook)
    assert re.search(r"^completed 0\.0\d\d mm$", printed, re.MULTILINE)
    assert "6 rotors" in printed and "adjustment gamma" in printed
    off, online, filtered = re.findall(r"^(?:residual|a filter).*: ([\d.]+) mm$", printed, re.M)
    assert float(online) < 0.6 * float(off) and float(filtered) < 0.8 * float(off)
    assert "lowest tool 1.100 m, lowest reference 1.080 m" in printed


def test_results_are_shown_as_tables_with_figures(notebook):
    data = [output.get("data", {}) for output in outputs(notebook)]
    pages = [str(each["text/html"]) for each in data if "text/html" in each]
    assert len(pages) == 2 and all("<table>" in page and "<svg" in page for page in pages)
    assert sum("image/png" in each for each in data) == 2


def test_the_saved_output_is_up_to_date(notebook):
    assert text(read(DIAGRAMS)) == text(notebook)


def test_it_has_all_that_the_guides_have():
    """README and the gallery say so: each guide to a part of one's own is linked."""
    prose = "".join(cell.source for cell in read(DIAGRAMS).cells if cell.cell_type == "markdown")
    links = set(re.findall(r"\]\(([^)#]+)\)", prose))
    assert all((DIAGRAMS / link).exists() for link in links)
    guides = {path.name for path in DIAGRAMS.glob("your_*.md")}
    assert guides | {"mpc.md", "testing_a_system.md"} <= links
