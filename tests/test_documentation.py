"""The blocks of README and the guides run, and their links are valid.

A page's blocks run in order in a folder with `diagrams/`. Flights are shortened to tenths of a
second without figures. Commands that take minutes are only checked for valid options, scenarios
and keys. `pytest --long` runs all commands as written, except for those that need a second process.
"""

import re
import shlex
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from aerodrake.cli import main, make_parser
from aerodrake.commands.options import load
from aerodrake.scenario.load import load_scenario, packaged_scenarios

ROOT = Path(__file__).parents[1]
README = ROOT / "README.md"
SITE = {"index.md", "changelog.md"}
"""Pages of the site alone, whose text is in files at the top."""
PAGES = [README, *(p for p in sorted((ROOT / "diagrams").glob("*.md")) if p.name not in SITE)]
GENERATED = sorted((ROOT / "diagrams" / "graphs").glob("*.md"))
"""Pages whose content is tested with their generator."""

SHORT = ["--set", "duration=0.2", "--set", "settle_s=0.1"]
SLOW = {"analyze", "budget", "compare", "identify", "train", "bench", "sweep", "mount"}
"""Commands that take minutes and have their own tests."""
NOT_ALONE = {"coordinator", "--lcm", "--scheduler"}
"""Commands and options that need a second process; they have their own tests."""
NOT_FLOWN = (".venv/", "python3 -m venv", ". .venv/", "pip ", "pytest", "dask ")
"""Commands that set up the machine or run the tests."""

pages = pytest.mark.parametrize("page", PAGES, ids=lambda page: page.parent.name + "_" + page.stem)


def blocks(page: Path) -> list[tuple[str, str]]:
    """Returns (language, text) of each fenced block."""
    return re.findall(r"^```(\w*)\n(.*?)^```$", page.read_text(), re.MULTILINE | re.DOTALL)


def lines(shell: str) -> Iterator[str]:
    """Yields the commands of a shell block without comments, with continued lines joined."""
    for line in shell.replace("\\\n", " ").splitlines():
        if command := re.sub(r"\s+#\s.*$", "", line).strip():
            yield command


def test_pages_and_blocks_are_found():
    assert len(PAGES) > 5 and len(GENERATED) > 20
    languages = {language for page in PAGES for language, _ in blocks(page)}
    assert languages == {"sh", "python", "yaml", "text"}  # Each block has a language.


def test_readme_is_short():
    assert len(README.read_text().splitlines()) <= 200


@pages
def test_every_block_runs(page, tmp_path, monkeypatch, long, request):
    if not long:
        request.getfixturevalue("undrawn")
    shutil.copytree(ROOT / "diagrams", tmp_path / "diagrams")
    monkeypatch.chdir(tmp_path)
    if not long:  # The result of a training that is not run.
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
    """Runs a line of a shell block."""
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
    """Checks that options, scenario and keys of a command are valid."""
    try:
        parsed = make_parser().parse_args(arguments)
    except SystemExit as stopped:
        assert stopped.code == 0, arguments
        return
    scenario = getattr(parsed, "scenario", "")
    if scenario and not Path(scenario).suffix:
        load(parsed)


def local_links() -> list[tuple[Path, str]]:
    links_of_pages = []
    for page in [*PAGES, *GENERATED]:
        links = re.findall(r"\]\(([^)\s]+)\)|(?:src|href)=\"([^\"]+)\"", page.read_text())
        targets = {one or other for one, other in links}
        links_of_pages += [
            (page, t) for t in sorted(targets) if not re.match(r"https?:|mailto:", t)
        ]
    return links_of_pages


def test_links_are_valid():
    assert local_links()
    for page, link in local_links():
        path, _, anchor = link.partition("#")
        target = page.parent / path if path else page
        assert not path.startswith("/") and target.exists(), f"{page}: {link}"
        if anchor:
            titles = re.findall(r"^#+ (.*)$", target.read_text(), re.MULTILINE)
            slugs = [re.sub(r"[^\w\- ]", "", t.lower()).replace(" ", "-") for t in titles]
            assert anchor in slugs, f"{page}: {link}"


def links_of(page: Path) -> set[str]:
    """Returns the files that a page links, relative to its folder."""
    return {link.partition("#")[0] for other, link in local_links() if other == page}


def test_the_gallery_links_every_script_and_system():
    gallery = ROOT / "diagrams" / "README.md"
    files = [*ROOT.glob("diagrams/*.py"), *ROOT.glob("diagrams/*.ipynb"), *GENERATED]
    assert {str(f.relative_to(gallery.parent)) for f in files} <= links_of(gallery)


def test_readme_and_the_site_link_every_page():
    pages = {page.stem for page in PAGES} - {"README"}
    assert {f"diagrams/{page}.md" for page in pages} <= links_of(README)
    entries = (ROOT / "diagrams" / "index.md").read_text().splitlines()
    assert pages <= {*entries}


@pages
def test_files_it_names_exist(page):
    """Checks paths in code spans and shell blocks that begin with a folder of the repository."""
    shell = " ".join(text for language, text in blocks(page) if language == "sh")
    words = re.findall(r"`([^`\n]+)`", page.read_text()) + shell.split()
    tops = ("aerodrake/", "diagrams/", "tests/", ".ci/", "pyproject.toml", "constraints.txt")
    for word in words:
        path, *_ = word.split("::")
        if path.startswith(tops) and re.fullmatch(r"[\w./-]+", path):
            assert (ROOT / path).exists(), word


def test_the_guide_names_every_packaged_scenario():
    guide = (ROOT / "diagrams" / "scenarios.md").read_text()
    for name in packaged_scenarios():
        assert f"`{name}`" in guide
