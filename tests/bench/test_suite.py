"""The benchmark suite with minimal effort: figures, table and command."""

import json
import math
from dataclasses import replace

import pytest

from aerodrake.bench import scaling as bench_scaling
from aerodrake.bench import solvers as bench_solvers
from aerodrake.bench import suite as module
from aerodrake.bench.figure import plot_bench
from aerodrake.bench.processes import process_figures as measured_processes
from aerodrake.bench.report import FILES, bench_table, missing_peers
from aerodrake.bench.suite import QUICK, STEPS, bench
from aerodrake.cli import main
from aerodrake.flight.summary import to_json
from aerodrake.model.qp.result import QpStatus
from aerodrake.model.qp.solvers import available_solvers

TINY = replace(QUICK, duration_s=0.1, settle_s=0.0, passes=1, scaling_s=0.04, loop_s=0.1, repeats=1)
PROCESSES = {
    "startup": {"help_s": 0.1, "hover_s": 2.0},
    "peak_rss_mb": 600.0,
    "rss_growth_mb": 3.0,
    "memory": {"clover_s": 2.0, "hover_s": 20.0, "short_hover_mb": 590.0, "long_hover_mb": 593.0},
}
MISSING = "piqp"


@pytest.fixture(scope="module")
def measured():
    """Figures, steps, notes and table, with one peer missing and without processes."""
    steps = []

    def processes(clover_s, hover_s, repeats, progress):
        for step in ("a", "b", "c"):
            progress(step)
        return PROCESSES

    def imported(name):
        if name == MISSING:
            raise ImportError(name)
        return import_module(name)

    import_module = bench_solvers.import_module
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "process_figures", processes)
        patch.setattr(bench_solvers, "import_module", imported)
        patch.setattr(bench_scaling, "HORIZONS", (3, 15, 30))
        patch.setattr(bench_scaling, "JOINTS", (4,))
        figures = bench(TINY, steps.append)
        return figures, steps, missing_peers(), bench_table(figures)


def test_figures_have_all_keys(measured):
    figures, _, _, _ = measured
    for key in ("median_ms", "p99_ms", "worst_ms", "u0_error_max", "overhead_ms"):
        assert figures["tick"][key] > 0
    assert set(figures["peers"]) == {"daqp", "piqp", "proxqp", "osqp", "clarabel"}
    names = {f"with {name}" for name in available_solvers()} - {"with osqp"}
    assert set(figures["solvers"]) == {"without shortcut", *names}
    for key in ("closed_loop_over_plant", "real_time_factor", "peak_rss_mb", "rss_growth_mb"):
        assert figures[key] > 0
    assert math.isfinite(figures["scaling"]["horizon_exponent"])
    assert json.loads(to_json(figures)) == figures


def test_progress_is_called_for_each_step(measured):
    _, steps, _, _ = measured
    assert len(steps) == STEPS


def test_a_missing_peer_is_reported_and_the_others_are_measured(measured):
    figures, _, notes, table = measured
    missing = figures["peers"][MISSING]
    assert missing["median_ms"] is missing["p99_ms"] is missing["version"] is None
    assert missing["median_ratio"] is missing["p99_ratio"] is None
    assert [note for note in notes if note.startswith(MISSING)] == [
        f"{MISSING} is skipped, since it is not installed: pip install aerodrake[bench]"
    ]
    assert "not installed" in table


def test_ratios_are_ours_over_theirs(measured):
    figures, _, _, _ = measured
    for name, peer in figures["peers"].items():
        if peer["version"] is None:
            continue
        for key in ("median", "p99"):
            ratio = figures["tick"][f"{key}_ms"] / peer[f"{key}_ms"]
            assert peer[f"{key}_ratio"] == pytest.approx(ratio), name
        assert peer["ticks"] == figures["tick"]["ticks"] == 15


def test_fractions_of_statuses_sum_to_one(measured):
    tick = measured[0]["tick"]
    assert set(tick["status_shares"]) == {status.name.lower() for status in QpStatus}
    for shares in (tick, *tick["scenarios"].values()):
        assert sum(shares["status_shares"].values()) == pytest.approx(1.0)


def test_parts_of_the_loop_are_measured(measured):
    loop = measured[0]["loop"]
    assert loop["closed_loop_ms_per_s"] / loop["plant_ms_per_s"] == pytest.approx(
        measured[0]["closed_loop_over_plant"]
    )
    assert {"mpc_forming_and_solving", "mpc_overhead"} < set(loop["systems_ms_per_s"])
    assert all(ms > 0 for ms in loop["systems_ms_per_s"].values())


def test_stages_scale_with_the_horizon(measured):
    rows = measured[0]["scaling"]["horizon"]
    assert [(row["N"], row["span_ticks"]) for row in rows] == [(3, 20), (15, 100), (30, 200)]


def test_table_and_figure(measured, tmp_path):
    figures, _, _, table = measured
    assert f"N^{figures['scaling']['horizon_exponent']:.2f}" in table
    assert "closed loop over bare plant" in table and "600 MB" in table
    plot_bench(figures, tmp_path / "bench.png")
    assert (tmp_path / "bench.png").read_bytes().startswith(b"\x89PNG")


def test_the_command_writes_its_files(measured, tmp_path, monkeypatch, capsys):
    efforts = []

    def canned(effort, progress):
        efforts.append(effort)
        return measured[0]

    monkeypatch.setattr(module, "bench", canned)
    file, out = tmp_path / "figures.json", tmp_path / "out"
    file.write_text("of an earlier one")
    assert main(["bench", "--quick", "--json", str(file), "--out", str(out)]) == 0
    assert efforts == [QUICK]
    assert json.loads(file.read_text()) == json.loads((out / "bench.json").read_text())
    assert sorted(path.name for path in out.iterdir()) == sorted(FILES)
    output = capsys.readouterr().out
    assert bench_table(measured[0]) in output and f"{out}: bench.json, bench.png" in output
    assert main(["bench", "--quiet", "--out", str(out)]) == 0  # An earlier one is replaced.
    assert efforts == [QUICK, module.FULL]
    assert capsys.readouterr() == ("", "")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--json", "nowhere/figures.json"], "--json: expected a file in an existing folder"),
        (["--json", "."], "--json: expected a file"),
        (["--out", "mine"], "mine: holds files that are not of"),
        (["--out", "mine/file"], "mine/file: expected a folder"),
        (["--fast"], "unrecognized arguments: --fast"),
        (["clover"], "unrecognized arguments: clover"),
    ],
)
def test_bad_options_are_refused_before_measuring(options, message, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(module, "bench", lambda *_: pytest.fail("it measured"))
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "file").write_text("")
    try:
        code = main(["bench", "--quiet", *options])
    except SystemExit as exit:
        code = exit.code
    assert code == 2
    error = capsys.readouterr().err
    assert message in error and error.count("\n") == 1
    assert sorted(p.name for p in tmp_path.rglob("*")) == ["file", "mine"]


def test_measured_commands(monkeypatch):
    from aerodrake.bench import processes as bench_processes
    from aerodrake.bench.processes import ProcessCost

    commands = []

    def run(*arguments):
        commands.append([a for a in arguments if not a.startswith("/")])
        return ProcessCost(1.0 / len(commands), 100.0 * len(commands))

    monkeypatch.setattr(bench_processes, "run_command", run)
    steps = []
    figures = measured_processes(2.0, 20.0, 2, steps.append)
    flown = ["run", "hover", "--quiet", "--out", "--duration"]
    assert commands[:2] == [["--help"]] * 2
    assert commands[2:4] == [[*flown, "1.0"]] * 2
    assert commands[4] == ["run", "clover", "--quiet", "--out", "--duration", "2.0"]
    assert commands[5] == [*flown, "20.0"]
    assert figures["startup"] == {"help_s": 0.5, "hover_s": 0.25}
    assert figures["peak_rss_mb"] == 500 and figures["rss_growth_mb"] == 200
    assert len(steps) == 3
