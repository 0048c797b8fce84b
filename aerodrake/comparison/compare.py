"""Variants of one flight: the paper's method, the method without one part, other methods."""

import dataclasses
import shutil
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from aerodrake.flight.simulate import FlightSimulation
from aerodrake.flight.summary import Summaries, failure, summarize
from aerodrake.reports.flight_folder import draw_tracking, write_results
from aerodrake.reports.flight_table import summary_notes
from aerodrake.scenario import OrientationOff, Scenario, Weights
from aerodrake.scenario.load import MAX_FILE_BYTES
from aerodrake.scenario.plain_yaml import parse
from aerodrake.scenario.schema import build
from aerodrake.station import make_closed_loop
from aerodrake.support.errors import BadInput, nearest, sourced
from aerodrake.support.files import PACKAGE, locate, read_bounded
from aerodrake.support.processes import run_parallel
from aerodrake.systems.sensors import is_exact

CLIK_MAX_K_E = 4.0
"""1/s, largest K_e of closed-loop inverse kinematics, which oscillates at 12."""

K_B_MODELS = {"position": "paper", "trajectory": "velocity_aware"}
"""Modified model with K_B alone, by flight interface."""

INTERFACE_MODELS = {"position": "paper", "trajectory": "flight"}
"""Modified model of a scenario whose own model is the integral one, by flight interface."""


def _with(**sections: Mapping[str, Any]) -> Callable[[Scenario], Scenario]:
    """Returns a function that changes keys of sections."""

    def change(scenario: Scenario) -> Scenario:
        changed = {name: replace(getattr(scenario, name), **sections[name]) for name in sections}
        return replace(scenario, **changed)

    return change


def _proposed(scenario: Scenario) -> Scenario:
    """Returns the scenario with the paper's method: MPC, modified model, weights by gamma."""
    kind = scenario.model.kind
    if kind == "integral":
        kind = INTERFACE_MODELS[scenario.flight.interface]
    method = _with(model={"kind": kind}, allocation={"kind": "gamma"})
    return replace(method(scenario), controller="mpc")


def _clik(scenario: Scenario) -> Scenario:
    """Bounds K_e: CLIK has no model of the base's lag, and is unstable with a large gain."""
    k_e = tuple(min(gain, CLIK_MAX_K_E) for gain in scenario.mpc.k_e)
    bounded = _with(residual={"mode": "off"}, mpc={"k_e": k_e})(scenario)
    return replace(bounded, controller="clik", orientation=OrientationOff())


def _no_flight_model(scenario: Scenario) -> Scenario:
    kind = K_B_MODELS[scenario.flight.interface]
    # A network for the flight model is not valid: its Delta is an acceleration.
    return _with(model={"kind": kind}, residual={"checkpoint": ""})(scenario)


PARTS: dict[str, Callable[[Scenario], Scenario]] = {
    "no_flight_model": _no_flight_model,
    "no_tilt": _with(mpc={"tilt": "none"}),
    "no_feedforward": _with(flight={"feedforward": "none"}),
    "short_horizon": _with(mpc={"span_ticks": 1}),
    "no_filter": _with(filter={"kind": "none"}),
}
"""Variants without one of the parts that this package adds to the paper's method, see `parts`."""

_integral = _with(residual={"mode": "off"}, model={"kind": "integral"})

VARIANTS: dict[str, Callable[[Scenario], Scenario]] = {
    "integral": _integral,
    "integral_best": _integral,  # With the weights of the baseline, see `make_variant`.
    "modified": _with(residual={"mode": "off"}),
    "modified+offline": _with(residual={"mode": "offline"}),
    "modified+online": _with(residual={"mode": "online", "as_printed": False}),
    "modified+printed": _with(residual={"mode": "online", "as_printed": True}),
    "clik": _clik,
    "fixed_weights": _with(allocation={"kind": "fixed"}),
    **PARTS,
}
"""Functions that change the scenario with the paper's method into each variant.

`integral` has the integral model, in which the base is always at its setpoint; `integral_best` has
it with the weights of a baseline. `modified` has the scenario's own model without a residual,
`modified+offline` with a fixed network, `modified+online` with online learning, `modified+printed`
with the paper's, which has no guards. `clik` is closed-loop inverse kinematics, with K_e bounded
and without orientation task. `fixed_weights` has no weight allocation. Each of the others lacks one
of `PARTS`.
"""


def own_variant(scenario: Scenario) -> str:
    """Returns the name of the variant that equals the scenario with the paper's method."""
    mode = scenario.residual.mode
    if mode == "off":
        return "modified"
    is_printed = mode == "online" and scenario.residual.as_printed
    return "modified+printed" if is_printed else f"modified+{mode}"


def make_variant(scenario: Scenario, name: str, baseline: Weights) -> Scenario:
    """Returns one variant of a scenario; `baseline` is used by `integral_best`."""
    variant = VARIANTS[name](_proposed(scenario))
    is_best = name == "integral_best"
    return _with(mpc=dataclasses.asdict(baseline))(variant) if is_best else variant


def load_baseline(scenario: Scenario, file: Path | None = None) -> Weights:
    """Reads the weights of a baseline file: the best ones of the integral model.

    Args:
        scenario: Its name selects the packaged file if `file` is None. If there is none of this
            name, all weights are at their defaults.
        file: YAML with keys of `Weights`, such as `k_e` and `w_4`; others are at their defaults.

    Raises:
        BadInput: if the file cannot be read, or is not valid.
    """
    packaged = locate(f"{PACKAGE}scenarios/baselines/{scenario.name}.yaml")
    if file is None and not packaged.is_file():
        return Weights()
    path = file or packaged
    text = read_bounded(path, MAX_FILE_BYTES).decode("utf-8", errors="replace")
    return build(Weights, parse(text, path), path)


def make_variants(
    scenario: Scenario, names: Sequence[str] = (), baseline: Weights | None = None
) -> dict[str, Scenario]:
    """Returns variants of a scenario, by name, in the order of `VARIANTS`.

    Args:
        scenario: Any scenario.
        names: Names of the variants; empty for all, except those without a part that the
            scenario does not have anyway, and `modified+printed` unless it learns online.
        baseline: Weights of `integral_best`; None for those of `load_baseline`.

    Raises:
        BadInput: if a name is unknown, or a variant cannot be flown.
    """
    for name in names:
        if name not in VARIANTS:
            raise BadInput("variants", "", f"no such variant '{name}'; {nearest(name, VARIANTS)}")
    baseline = baseline or load_baseline(scenario)
    absent = PARTS.keys() - parts(_proposed(scenario))
    if scenario.residual.mode != "online":
        absent |= {"modified+printed"}
    chosen = [name for name in VARIANTS if name in names or not names and name not in absent]
    variants = {}
    for name in chosen:
        with sourced(f"{scenario.source} as {name}"):
            variants[name] = make_variant(scenario, name, baseline)
            # Reads the files of the scenario, so that errors occur before any flight.
            make_closed_loop(variants[name])
    return variants


def parts(scenario: Scenario) -> list[str]:
    """Returns the keys of `PARTS` that change the flight of a scenario."""
    is_present = {
        "no_flight_model": scenario.model.kind == "flight",
        "no_tilt": scenario.mpc.tilt != "none",
        "no_feedforward": scenario.flight.feedforward != "none",
        "short_horizon": scenario.mpc.span_ticks > scenario.mpc.horizon,
        "no_filter": scenario.filter.kind != "none" and not is_exact(scenario.sensors),
    }
    return [name for name in PARTS if is_present[name]]


def comparison_notes(scenario: Scenario) -> list[str]:
    """Returns notes on the comparison of a scenario."""
    if scenario.residual.checkpoint:
        return []
    return [
        "residual.checkpoint names no network: modified+offline is the same as modified, and "
        "modified+online begins with an untrained network"
    ]


def result_notes(summaries: Summaries) -> list[str]:
    """Returns notes on the results of variants that did not fail."""
    return [
        f"{name}: {note}"
        for name, summary in summaries.items()
        if "residual" in summary
        for note in summary_notes(summary)
    ]


def fly_variants(
    variants: Mapping[str, Scenario],
    folder: Path,
    jobs: int,
    progress: Callable[[str], None] = lambda name: None,
) -> dict[str, dict[str, Any]]:
    """Flies each variant in a process of its own and writes its results to a folder of its name.

    Args:
        variants: Scenarios by name.
        folder: Parent of the variants' folders.
        jobs: Number of concurrent processes.
        progress: Called with the name of each variant that has ended.

    Returns:
        The summary of each variant, in the order of `variants`. If the process of a variant
        raises or dies, its summary has only `exit_reason` failed and `exit_cause`, and its
        folder is removed.

    Raises:
        OSError: if a folder cannot be written.
    """
    summaries: dict[str, dict[str, Any]] = dict.fromkeys(variants, {})
    flights = [(variant, folder / name) for name, variant in variants.items()]
    for index, summary in run_parallel(_fly, flights, jobs):
        own = flights[index][1]
        if isinstance(summary, OSError | BadInput):
            raise summary  # Not caused by the variant: a full disk, for example.
        if isinstance(summary, Exception):
            shutil.rmtree(own, ignore_errors=True)
            summary = failure(summary)
        summaries[own.name] = summary
        progress(own.name)
    return summaries


def _fly(flight: tuple[Scenario, Path]) -> dict[str, Any]:
    scenario, folder = flight
    folder.mkdir()
    log = FlightSimulation(scenario).fly()
    summary = summarize(scenario, log)
    write_results(folder, scenario, summary, log)
    title = f"{scenario.name} as {folder.name}, seed {scenario.seed}"
    draw_tracking(folder, scenario, log, title)
    return summary
