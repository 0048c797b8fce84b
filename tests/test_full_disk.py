"""A disk that is full, at any file: one line, exit code 2, and earlier results as they were."""

import resource
import subprocess
import sys
from pathlib import Path

import pytest

ARGV = ["run", "hover", "--set", "settle_s=0", "--duration", "0.2", "--quiet", "--out", "results"]


def run(folder: Path, most_bytes: int | None = None) -> subprocess.CompletedProcess:
    """With files that can grow no longer than that, as on a disk without room."""

    def limit() -> None:
        if most_bytes is not None:
            resource.setrlimit(resource.RLIMIT_FSIZE, (most_bytes, most_bytes))

    command = [sys.executable, "-m", "aerodrake", *ARGV]
    return subprocess.run(
        command, cwd=folder, preexec_fn=limit, capture_output=True, text=True, timeout=600
    )


def content(folder: Path) -> dict[str, bytes]:
    return {str(p.relative_to(folder)): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


@pytest.fixture(scope="module")
def flown(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("flown")
    assert run(folder).returncode == 0
    return folder


@pytest.mark.parametrize(
    ("most_bytes", "what"),
    [(1000, "during the flight"), (100_000, "results"), (1_000_000, "results")],
    ids=["recording", "plot", "replay"],
)
def test_earlier_results_stay(flown, most_bytes, what):
    before = content(flown)
    done = run(flown, most_bytes)
    assert done.returncode == 2 and done.stdout == ""
    assert len(done.stderr.splitlines()) == 1 and "File too large" in done.stderr
    assert what in done.stderr
    assert content(flown) == before and [p.name for p in flown.iterdir()] == ["results"]
