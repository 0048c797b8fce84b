"""Commands in separate processes: their cost, and errors of failed commands."""

import pytest

from aerodrake.bench.processes import run_command


def test_a_command_is_measured():
    cost = run_command("--version")
    assert 0 < cost.wall_s < 60
    # More than an interpreter, less than this process with all its libraries.
    assert 5 < cost.peak_rss_mb < 200


def test_a_failed_command_raises_with_its_message():
    with pytest.raises(RuntimeError, match="run no_such ended with 2: aerodrake: no_such"):
        run_command("run", "no_such")
