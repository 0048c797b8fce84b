"""A full disk gives one line and exit code 2, and preserves earlier results."""

from pathlib import Path

import pytest

from aerodrake.cli import main
from tests.room import room_for

ARGV = ["run", "hover", "--set", "settle_s=0", "--duration", "0.2", "--quiet", "--out"]


def content(folder: Path) -> dict[str, bytes]:
    return {str(p.relative_to(folder)): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


@pytest.fixture(scope="module")
def earlier(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("earlier")
    assert main([*ARGV, str(folder / "results")]) == 0
    return folder


@pytest.mark.parametrize(
    ("most_bytes", "expected"),
    [(1000, "during the flight"), (100_000, "results"), (1_000_000, "results")],
    ids=["recording", "plot", "replay"],
)
def test_earlier_results_are_preserved(earlier, most_bytes, expected, capsys):
    before = content(earlier)
    with room_for(most_bytes):
        assert main([*ARGV, str(earlier / "results")]) == 2
    output, error = capsys.readouterr()
    assert output == "" and len(error.splitlines()) == 1
    assert "File too large" in error and expected in error
    assert content(earlier) == before and [p.name for p in earlier.iterdir()] == ["results"]
