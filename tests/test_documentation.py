"""README and the guides say what is so: their blocks run, their links lead somewhere.

A page's blocks run from top to bottom, as a reader would, in a folder that has
`diagrams/`. Flights are cut to tenths of a second and draw nothing, and commands that take
minutes are only checked: their options exist, their scenarios and keys are valid. `pytest
--long` runs all of them as they stand, but for those that need another process beside them.
"""

import re
import shlex
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from aerodrake.cli import main, make_parser
from aerodrake.commands.options import overrides
from aerodrake.scenario.load import load_scenario, packaged_scenarios

ROOT = Path(__file__).parents[1]
README = ROOT / "README.md"
PAGES = [README, *sorted((ROOT / "diagrams").glob("*.md"))]
GENERATED = sorted((ROOT / "diagrams" / "graphs").glob("*.md"))
"""Whose content is tested where it is made."""

SHORT = ["--set", "duration=0.2", "--set", "settle_s=0.1"]
SLOW = {"compare", "identify", "train", "bench", "sweep"}
"""Commands that take minutes, each with tests of its own."""
NOT_ALONE = {"coordinator", "--lcm", "--scheduler"}
"""What needs another process beside it, and has tests with both."""
NOT_FLOWN = (".venv/", "python3 -m venv", ". .venv/", "pip ", "pytest", "dask ")
"""How a machine is set up, and the tests: what runs before this."""

pages = pytest.mark.parametrize("page", PAGES, ids=lambda page: page.parent.name + "_" + page.stem)


def blocks(page: Path) -> list[tuple[str, str]]:
    """(language, text) of each fenced block."""
    return re.findall(r"^```(\w*)\n(.*?)^```$", page.read_text(), re.MULTILINE | re.DOTALL)


def lines(shell: str) -> Iterator[str]:
    """Commands of a shell block, without comments, continued lines joined."""
    for line in shell.replace("\\\n", " ").splitlines():
        if command := re.sub(r"\s+#\s.*$", "", line).strip():
            yield command


def test_there_is_something_to_check():
    assert len(PAGES) > 5 and len(GENERATED) > 20
    languages = {language for page in PAGES for language, _ in blocks(page)}
    assert languages == {"sh", "python", "yaml", "mermaid", "text"}  # Each block has its language.


@pages
def test_every_block_runs(page, tmp_path, monkeypatch, long, request):
    if not long:
        request.getfixturevalue("undrawn")
    shutil.copytree(ROOT / "diagrams", tmp_path / "diagrams")
    monkeypatch.chdir(tmp_path)
    if not long:  # Of a training that is not run here.
        network = Path("runs/train-mine/network.pt")
        network.parent.mkdir(parents=True)
        shutil.copy(ROOT / "aerodrake" / "networks" / "position.pt", network)
    names = {"__name__": "__main__"}
    for language, text in blocks(page):
        if language == "python":
            exec(compile(text, str(page), "exec"), names)
        elif language == "yaml":
            scenario = Path("diagrams", "from_a_block.yaml")
            scenario.write_text(text)
            load_scenario(str(scenario))
        elif language == "sh":
            for command in lines(text):
                run(command, long)


def run(command: str, long: bool) -> None:
    """A line of a shell block."""
    words = shlex.split(command)
    if words[0] == "aerodrake":
        arguments = words[1:] if long else shortened(words[1:])
        if not NOT_ALONE & {*words} and (long or arguments[0] not in SLOW):
            assert run_command(arguments) == 0, command
        check(words[1:])
    elif not command.startswith(NOT_FLOWN) and words[0] != "python":
        subprocess.run(["bash", "-euo", "pipefail", "-c", command], check=True)
    elif words[0] == "python":
        assert Path(words[1]).is_file()  # Scripts in diagrams/ run in tests/test_diagrams.py.


def shortened(arguments: list[str]) -> list[str]:
    if arguments[0] != "run":
        return arguments
    if "--duration" in arguments:
        at = arguments.index("--duration")
        arguments = arguments[:at] + arguments[at + 2 :]
    return [*arguments, *SHORT]


def run_command(arguments: list[str]) -> int:
    try:
        return main(arguments)
    except SystemExit as stopped:  # As `--help` does.
        return stopped.code


def check(arguments: list[str]) -> None:
    """Its options exist, and its scenario and keys are valid."""
    try:
        parsed = make_parser().parse_args(arguments)
    except SystemExit as stopped:
        assert stopped.code == 0, arguments
        return
    scenario = getattr(parsed, "scenario", "")
    if scenario and not Path(scenario).suffix:
        load_scenario(scenario, overrides(parsed))


def test_the_graph_is_that_of_the_wiring():
    graph = (ROOT / "diagrams" / "graphs" / "closed_loop.mmd").read_text()
    assert ("mermaid", graph) in blocks(README)


def local_links() -> list[tuple[Path, str]]:
    found = []
    for page in [*PAGES, *GENERATED]:
        links = re.findall(r"\]\(([^)\s]+)\)|(?:src|href)=\"([^\"]+)\"", page.read_text())
        targets = {one or other for one, other in links}
        found += [(page, t) for t in sorted(targets) if not re.match(r"https?:|mailto:", t)]
    return found


def test_links_lead_somewhere():
    assert local_links()
    for page, link in local_links():
        path, _, anchor = link.partition("#")
        target = page.parent / path if path else page
        assert not path.startswith("/") and target.exists(), f"{page}: {link}"
        if anchor:
            titles = re.findall(r"^#+ (.*)$", target.read_text(), re.MULTILINE)
            slugs = [re.sub(r"[^\w\- ]", "", t.lower()).replace(" ", "-") for t in titles]
            assert anchor in slugs, f"{page}: {link}"


def test_every_script_and_page_has_its_place_in_the_gallery():
    gallery = ROOT / "diagrams" / "README.md"
    links = {link.partition("#")[0] for page, link in local_links() if page == gallery}
    files = [*ROOT.glob("diagrams/*.py"), *ROOT.glob("diagrams/*.md"), *GENERATED]
    files += ROOT.glob("diagrams/*.ipynb")
    assert {str(f.relative_to(gallery.parent)) for f in files} - {"README.md"} <= links | {
        "graphs/closed_loop.md"
    }


@pages
def test_files_it_names_exist(page):
    """Paths in code spans and shell blocks that can only be of this repository."""
    shell = " ".join(text for language, text in blocks(page) if language == "sh")
    words = re.findall(r"`([^`\n]+)`", page.read_text()) + shell.split()
    tops = ("aerodrake/", "diagrams/", "tests/", ".ci/", "pyproject.toml", "constraints.txt")
    for word in words:
        path, *_ = word.split("::")
        if path.startswith(tops) and re.fullmatch(r"[\w./-]+", path):
            assert (ROOT / path).exists(), word


def test_readme_names_every_packaged_scenario():
    for name in packaged_scenarios():
        assert f"`{name}`" in README.read_text()
