"""Variants of one flight: the paper's method, the method without one part, other methods."""

import dataclasses
import shutil
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from aerodrake.comparison.baseline import load_baseline
from aerodrake.flight.simulate import FlightSimulation
from aerodrake.flight.summary import failure
from aerodrake.reports.flight_folder import fly_into
from aerodrake.scenario import OrientationOff, Scenario, Weights
from aerodrake.scenario.rules import check
from aerodrake.station import make_closed_loop
from aerodrake.support.errors import BadInput, nearest
from aerodrake.support.processes import run_parallel
from aerodrake.systems.sensors import is_exact

FILES = ("comparison.json", "comparison.png", "report.html")
"""Files that a comparison writes, beside one folder for each variant."""

CLIK_MAX_K_E = 4.0
"""1/s, largest K_e of closed-loop inverse kinematics, which oscillates at 12."""

K_B_MODELS = {"position": "paper", "trajectory": "velocity_aware"}
"""Modified model with K_B alone, by flight interface."""

INTERFACE_MODELS = {"position": "paper", "trajectory": "flight"}
"""Modified model of a scenario whose own model is the integral one, by flight interface."""


def _with(section: str, **keys: Any) -> Callable[[Scenario], Scenario]:
    """Returns a function that changes keys of one section."""
    return lambda scenario: replace(
        scenario, **{section: replace(getattr(scenario, section), **keys)}
    )


def _proposed(scenario: Scenario) -> Scenario:
    """Returns the scenario with the paper's method: MPC, modified model, weights by gamma."""
    model = scenario.model
    if model.kind == "integral":
        model = replace(model, kind=INTERFACE_MODELS[scenario.flight.interface])
    return replace(
        scenario,
        controller="mpc",
        model=model,
        allocation=replace(scenario.allocation, kind="gamma"),
    )


def _with_residual(scenario: Scenario, mode: str) -> Scenario:
    return _with("residual", mode=mode)(scenario)


def _integral(scenario: Scenario) -> Scenario:
    return _with("model", kind="integral")(_with_residual(scenario, "off"))


def _clik(scenario: Scenario) -> Scenario:
    """Bounds K_e: CLIK has no model of the base's lag, and becomes unstable at a large one."""
    k_e = tuple(min(gain, CLIK_MAX_K_E) for gain in scenario.mpc.k_e)
    without_residual = _with("mpc", k_e=k_e)(_with_residual(scenario, "off"))
    return replace(without_residual, controller="clik", orientation=OrientationOff())


PARTS: dict[str, Callable[[Scenario], Scenario]] = {
    "no_flight_model": lambda scenario: _with("model", kind=K_B_MODELS[scenario.flight.interface])(
        scenario
    ),
    "no_tilt": _with("mpc", tilt="none"),
    "no_feedforward": _with("flight", feedforward="none"),
    "short_horizon": _with("mpc", span_ticks=1),
    "no_filter": _with("filter", kind="none"),
}
"""Variants without one of the parts that this package adds to the paper's method, see `parts`."""

VARIANTS: dict[str, Callable[[Scenario], Scenario]] = {
    "integral": _integral,
    "integral_best": _integral,  # With the weights of the baseline, see `make_variant`.
    "modified": lambda scenario: _with_residual(scenario, "off"),
    "modified+offline": lambda scenario: _with_residual(scenario, "offline"),
    "modified+online": lambda scenario: _with_residual(scenario, "online"),
    "clik": _clik,
    "fixed_weights": _with("allocation", kind="fixed"),
    **PARTS,
}
"""Functions that change the scenario with the paper's method into each variant.

`integral` has the integral model, for which the base is where it is commanded to be;
`integral_best` has it with the weights of a baseline. `modified` has the scenario's own model
without a residual, `modified+offline` with a fixed network, `modified+online` with online
learning. `clik` is closed-loop inverse kinematics, with K_e bounded and without orientation
task. `fixed_weights` has no weight allocation. Each of the others lacks one of `PARTS`.
"""

OWN_VARIANT = {"off": "modified", "offline": "modified+offline", "online": "modified+online"}
"""Variant that equals the scenario with the paper's method, by its `residual.mode`."""


def make_variant(scenario: Scenario, name: str, baseline: Weights) -> Scenario:
    """Returns one variant of a scenario, unchecked; `baseline` is used by `integral_best`."""
    variant = VARIANTS[name](_proposed(scenario))
    if name != "integral_best":
        return variant
    return _with("mpc", **dataclasses.asdict(baseline))(variant)


def make_variants(
    scenario: Scenario, names: Sequence[str] = (), baseline: Weights | None = None
) -> dict[str, Scenario]:
    """Returns variants of a scenario, by name, in the order of `VARIANTS`.

    Args:
        scenario: Any scenario.
        names: Names of the variants; empty for all but those that lack a part which the
            scenario does not have.
        baseline: Weights of `integral_best`; None for those of `load_baseline`.

    Raises:
        BadInput: if a name is unknown, or a variant cannot be flown.
    """
    for name in names:
        if name not in VARIANTS:
            raise BadInput("--variant", "", f"no such variant '{name}'; {nearest(name, VARIANTS)}")
    baseline = baseline or load_baseline(scenario)
    absent = PARTS.keys() - parts(_proposed(scenario))
    chosen = [name for name in VARIANTS if name in names or not names and name not in absent]
    variants = {name: make_variant(scenario, name, baseline) for name in chosen}
    for name, variant in variants.items():
        source = f"{scenario.source} as {name}"
        check(variant, source)
        # Reads the files of the scenario, so that errors occur before any flight.
        make_closed_loop(replace(variant, source=source))
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


def notes(scenario: Scenario) -> list[str]:
    """Returns notes on the comparison of a scenario."""
    if scenario.residual.checkpoint:
        return []
    return [
        "residual.checkpoint names no network: modified+offline is the same as modified, and "
        "modified+online begins with an untrained network"
    ]


def compare(
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
    names = list(variants)
    outcomes: dict[str, dict[str, Any]] = {}
    flights = [(variants[name], folder / name) for name in names]
    for index, outcome in run_parallel(_fly, flights, jobs):
        name = names[index]
        if isinstance(outcome, OSError | BadInput):
            raise outcome  # Not caused by the variant: a full disk, for example.
        if isinstance(outcome, Exception):
            shutil.rmtree(folder / name, ignore_errors=True)
            outcome = failure(outcome)
        outcomes[name] = outcome
        progress(name)
    return {name: outcomes[name] for name in names}


def _fly(flight: tuple[Scenario, Path]) -> dict[str, Any]:
    scenario, folder = flight
    folder.mkdir()
    title = f"{scenario.name} as {folder.name}, seed {scenario.seed}"
    summary, _ = fly_into(folder, FlightSimulation(scenario), title)
    return summary
