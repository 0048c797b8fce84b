"""The README says what is so."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text()

BLOCKS = re.findall(r"^```(\w+)\n(.*?)^```$", README, re.MULTILINE | re.DOTALL)


def blocks(language: str) -> list[str]:
    return [text for name, text in BLOCKS if name == language]


def test_there_is_something_to_check():
    assert blocks("python") and blocks("mermaid")
    assert README.count("```") == 2 * len(BLOCKS)  # Each with its language.


@pytest.mark.parametrize("code", blocks("python"), ids=range(len(blocks("python"))))
def test_python_runs(code, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    exec(compile(code, "README.md", "exec"), {"__name__": "__main__"})


def test_the_graph_is_that_of_the_wiring():
    graph = (ROOT / "diagrams" / "graphs" / "closed_loop.mmd").read_text()
    assert graph.strip() in [text.strip() for text in blocks("mermaid")]


def local_links() -> list[str]:
    links = re.findall(r"\]\(([^)\s]+)\)|(?:src|href)=\"([^\"]+)\"", README)
    targets = {one or other for one, other in links}
    return sorted(t for t in targets if not t.startswith(("http://", "https://", "mailto:")))


@pytest.mark.parametrize("link", local_links())
def test_links_lead_somewhere(link):
    path, _, anchor = link.partition("#")
    assert not path.startswith("/") and (ROOT / path).exists()
    if anchor and path in ("", "README.md"):
        titles = re.findall(r"^#+ (.*)$", README, re.MULTILINE)
        slugs = [re.sub(r"[^\w\- ]", "", t.lower()).replace(" ", "-") for t in titles]
        assert anchor in slugs


def named_files() -> list[str]:
    """Paths in code spans and shell blocks that can only be of this repository."""
    words = re.findall(r"`([^`\n]+)`", README) + " ".join(blocks("sh") + blocks("bash")).split()
    tops = ("aerodrake/", "diagrams/", "tests/", ".ci/", "pyproject.toml", "constraints.txt")
    return sorted({w for w in words if w.startswith(tops) and re.fullmatch(r"[\w./-]+", w)})


@pytest.mark.parametrize("file", named_files())
def test_files_it_names_exist(file):
    assert (ROOT / file).exists()


def commands() -> list[str]:
    """The `aerodrake` commands in its shell blocks, continued lines joined."""
    text = "\n".join(blocks("sh") + blocks("bash") + blocks("console")).replace("\\\n", " ")
    found = (re.match(r"^(?:\$ )?(aerodrake .*?)(?:\s+#.*)?$", line) for line in text.splitlines())
    return [match[1] for match in found if match]


@pytest.mark.parametrize("command", commands())
def test_commands_are_understood(command):
    """Their options exist, and their scenarios and keys are valid; nothing is flown."""
    import shlex

    from aerodrake.cli import make_parser
    from aerodrake.commands.options import overrides
    from aerodrake.scenario_file import load_scenario

    try:
        arguments = make_parser().parse_args(shlex.split(command)[1:])
    except SystemExit as exit:
        assert exit.code == 0
        return
    if hasattr(arguments, "scenario") and not Path(arguments.scenario).suffix:
        load_scenario(arguments.scenario, overrides(arguments))


def test_it_names_every_packaged_scenario():
    from aerodrake.scenario_file import packaged_scenarios

    for name in packaged_scenarios():
        assert f"`{name}`" in README
