"""The command line: its options, and how it ends as a process."""

import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

import pytest

from aerodrake.cli import main


@pytest.mark.parametrize(
    ("argv", "said"),
    [
        (["run", "clovr"], "did you mean 'clover'?"),
        (["run", "hover", "--set", "mpc.horizon=x"], "mpc.horizon: expected a whole number"),
        (["train", "clovr"], "did you mean 'clover'?"),
        (["train", "--jobs", "0"], "expected a whole number in [1, 1000], got '0'"),
    ],
)
def test_bad_input_to_the_process(argv, said, tmp_path):
    command = [sys.executable, "-m", "aerodrake", *argv]
    done = subprocess.run(command, capture_output=True, text=True, timeout=100, cwd=tmp_path)
    assert done.returncode == 2 and done.stdout == ""
    assert said in done.stderr and len(done.stderr.splitlines()) == 1
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "argv",
    [
        ["--help"],
        *(
            [c, "--help"]
            for c in ("run", "coordinator", "compare", "train", "sweep", "graph", "bench")
        ),
        ["--version"],
        ["fly"],
    ],
)
def test_help_needs_neither_drake_nor_torch(argv):
    code = (
        "import sys\n"
        "from aerodrake.cli import main\n"
        "try: main(sys.argv[1:])\n"
        "except SystemExit: pass\n"
        "heavy = {'torch', 'pydrake', 'matplotlib', 'numpy', 'scipy'} & set(sys.modules)\n"
        "sys.exit(f'imported {heavy}' if heavy else 0)"
    )
    done = subprocess.run([sys.executable, "-c", code, *argv], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_version_and_help(capsys):
    for argv, said in (
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
        assert said in capsys.readouterr().out


def test_train_takes_the_scenario_and_options_it_is_given(tmp_path, monkeypatch, capsys):
    from aerodrake.learning import train
    from aerodrake.learning.collection_runs import CollectionRun, paper_runs, quick_runs
    from aerodrake.learning.evaluation import METHODS, Evaluation

    asked = []

    def train_scenario(*arguments):
        asked.append(arguments)
        return Evaluation(
            [CollectionRun("calm", "held_out", 1.0, 5.0, 0.0)], [dict.fromkeys(METHODS, 1.0)]
        )

    monkeypatch.setattr(train, "train_scenario", train_scenario)
    monkeypatch.chdir(tmp_path)
    assert main(["train", "--seed", "4", "--jobs", "3"]) == 0
    assert "train-clover_paper: network.pt" in capsys.readouterr().out
    assert main(["train", "clover", "--quick", "--quiet", "--out", "x"]) == 0
    assert capsys.readouterr().out == ""
    (scenario, runs, _, folder, jobs, quiet), (other, fewer, _, out, _, silent) = asked
    assert (scenario.name, scenario.seed, folder) == (
        *("clover_paper", 4),
        Path("runs/train-clover_paper"),
    )
    assert (runs, jobs, quiet) == (paper_runs(), 3, False)
    assert (other.name, fewer, out, silent) == ("clover", quick_runs(), Path("x"), True)


def test_what_has_nothing_to_be_trained_is_told_in_one_line(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["train", "--set", "model.kind=integral"]) == 2
    said, error = capsys.readouterr()
    assert said == "" and len(error.splitlines()) == 1
    assert "the integral model has no residual" in error
    assert list(tmp_path.iterdir()) == []


def test_graph_writes_what_it_says(tmp_path, capsys):
    assert main(["graph", "coordinator", "--out", str(tmp_path / "graphs")]) == 0
    said = sorted(Path(line) for line in capsys.readouterr().out.splitlines())
    assert said == sorted((tmp_path / "graphs").iterdir())
    assert {"coordinator.dot", "coordinator.mmd"} <= {path.name for path in said}
