"""A disk that is full, at any file: one line, exit code 2, and earlier results as they were."""

from pathlib import Path

import pytest

from aerodrake.cli import main
from tests.room import room_for

ARGV = ["run", "hover", "--set", "settle_s=0", "--duration", "0.2", "--quiet", "--out"]


def content(folder: Path) -> dict[str, bytes]:
    return {str(p.relative_to(folder)): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


@pytest.fixture(scope="module")
def flown(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("flown")
    assert main([*ARGV, str(folder / "results")]) == 0
    return folder


@pytest.mark.parametrize(
    ("most_bytes", "what"),
    [(1000, "during the flight"), (100_000, "results"), (1_000_000, "results")],
    ids=["recording", "plot", "replay"],
)
def test_earlier_results_stay(flown, most_bytes, what, capsys):
    before = content(flown)
    with room_for(most_bytes):
        assert main([*ARGV, str(flown / "results")]) == 2
    said, error = capsys.readouterr()
    assert said == "" and len(error.splitlines()) == 1
    assert "File too large" in error and what in error
    assert content(flown) == before and [p.name for p in flown.iterdir()] == ["results"]
