"""A full disk gives one line for what is missing, and preserves what is there."""

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


def test_earlier_results_are_preserved_if_the_flight_cannot_be_recorded(earlier, capsys):
    before = content(earlier)
    with room_for(1000):
        assert main([*ARGV, str(earlier / "results")]) == 2
    output, error = capsys.readouterr()
    assert output == "" and len(error.splitlines()) == 1
    assert "File too large" in error and "during the flight" in error
    assert content(earlier) == before and [p.name for p in earlier.iterdir()] == ["results"]


@pytest.mark.parametrize(
    ("most_bytes", "missing"),
    [
        (100_000, {"tracking.png", "replay.html", "report.html"}),
        (1_000_000, {"replay.html", "report.html"}),
    ],
)
def test_results_are_kept_if_they_cannot_be_drawn(earlier, most_bytes, missing, tmp_path, caplog):
    """Each drawing that is missing is named in one line."""
    with room_for(most_bytes):
        assert main([*ARGV, str(tmp_path / "results")]) == 0
    written, whole = content(tmp_path / "results"), content(earlier / "results")
    assert whole.keys() - written.keys() == missing
    assert written["scenario.yaml"] == whole["scenario.yaml"] and written["log.npz"]
    assert len(caplog.messages) == len(missing)
    for name in missing:
        assert any(f"{name} is not drawn: " in message for message in caplog.messages)
