"""Options of the command line, and its exit codes as a process."""

import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

import pytest

from aerodrake.cli import main


@pytest.mark.parametrize(
    ("argv", "expected"),
    [
        (["run", "clovr"], "did you mean 'clover'?"),
        (["run", "hover", "--set", "mpc.horizon=x"], "mpc.horizon: expected a whole number"),
        (["train", "clovr"], "did you mean 'clover'?"),
        (["train", "--jobs", "0"], "expected a whole number in [1, 1000], got '0'"),
    ],
)
def test_bad_input_of_the_process(argv, expected, tmp_path):
    command = [sys.executable, "-m", "aerodrake", *argv]
    done = subprocess.run(command, capture_output=True, text=True, timeout=100, cwd=tmp_path)
    assert done.returncode == 2 and done.stdout == ""
    assert expected in done.stderr and len(done.stderr.splitlines()) == 1
    assert list(tmp_path.iterdir()) == []


def test_a_scenario_is_not_taken_for_the_option_of_its_name(capsys):
    assert main(["run", "seed"]) == 2
    assert capsys.readouterr().err.startswith("aerodrake: seed: no such scenario")


def test_help_needs_neither_drake_nor_torch():
    code = (
        "import sys\n"
        "from aerodrake.cli import COMMANDS, main\n"
        "for argv in (['--help'], ['--version'], ['fly'], *([c, '--help'] for c in COMMANDS)):\n"
        "    try: main(argv)\n"
        "    except SystemExit: pass\n"
        "    heavy = {'torch', 'pydrake', 'matplotlib', 'numpy', 'scipy'} & set(sys.modules)\n"
        "    if heavy: sys.exit(f'{argv} imports {heavy}')"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_version_and_help(capsys):
    for argv, expected in (
        (["--version"], f"aerodrake {version('aerodrake')}\n"),
        (["--help"], "fly a scenario"),
        (["run", "--help"], "--set KEY=VALUE"),
        (["coordinator", "--help"], "--lcm URL"),
        (["compare", "--help"], "--jobs N"),
        (["train", "--help"], "--quick"),
        (["sweep", "--help"], "--vary KEY=DIST"),
        (["graph", "--help"], "closed_loop, station, coordinator or a system"),
        (["bench", "--help"], "--json FILE"),
    ):
        with pytest.raises(SystemExit, match="0"):
            main(argv)
        assert expected in capsys.readouterr().out


def test_train_passes_on_its_options(tmp_path, monkeypatch, capsys):
    from aerodrake.learning import train
    from aerodrake.learning.collection_runs import CollectionRun, paper_runs, quick_runs
    from aerodrake.learning.evaluation import METHODS, NetworkEvaluation

    calls = []

    def train_scenario(*arguments):
        calls.append(arguments)
        return NetworkEvaluation(
            [CollectionRun("calm", "held_out", 1.0, 5.0, 0.0)], [dict.fromkeys(METHODS, 1.0)]
        )

    monkeypatch.setattr(train, "train_scenario", train_scenario)
    monkeypatch.chdir(tmp_path)
    assert main(["train", "--seed", "4", "--jobs", "3"]) == 0
    assert "train-clover_paper: network.pt" in capsys.readouterr().out
    assert main(["train", "clover", "--quick", "--quiet", "--out", "x"]) == 0
    assert capsys.readouterr().out == ""
    (scenario, runs, _, folder, jobs, quiet), (other, fewer, _, out, _, silent) = calls
    assert (scenario.name, scenario.seed, folder) == (
        *("clover_paper", 4),
        Path("runs/train-clover_paper"),
    )
    assert (runs, jobs, quiet) == (paper_runs(), 3, False)
    assert (other.name, fewer, out, silent) == ("clover", quick_runs(), Path("x"), True)


def test_a_model_without_residual_is_refused(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["train", "--set", "model.kind=integral"]) == 2
    output, error = capsys.readouterr()
    assert output == "" and len(error.splitlines()) == 1
    assert "the integral model has no residual" in error
    assert list(tmp_path.iterdir()) == []


def test_graph_prints_the_files_that_it_writes(tmp_path, capsys):
    assert main(["graph", "coordinator", "--out", str(tmp_path / "graphs")]) == 0
    output = sorted(Path(line) for line in capsys.readouterr().out.splitlines())
    assert output == sorted((tmp_path / "graphs").iterdir())
    assert {"coordinator.dot", "coordinator.mmd"} <= {path.name for path in output}
