"""The same flight by the paper's method, without parts of it, and by other methods."""

from __future__ import annotations

import dataclasses
import shutil
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from aerodrake.flight.simulate import FlightSimulation
from aerodrake.flight.summary import failure
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.reports.flight_folder import fly_into
from aerodrake.scenario import OrientationOff, Scenario
from aerodrake.scenario.rules import check
from aerodrake.station import make_closed_loop
from aerodrake.support.errors import BadInput, nearest
from aerodrake.support.processes import run_parallel
from aerodrake.systems.sensors import is_exact

FILES = ("comparison.json", "comparison.png", "report.html")
"""What a comparison leaves behind, beside a folder for each variant."""

CLIK_MOST_K_E = 4.0
"""1/s. At 12 closed-loop inverse kinematics throws the tool about."""

K_B_MODELS = {"position": "paper", "trajectory": "velocity_aware"}
"""The modified model of each flight interface that knows K_B alone."""

INTERFACE_MODELS = {"position": "paper", "trajectory": "flight"}
"""The modified model of each flight interface, where the scenario names none."""


def _with(section: str, **keys: Any) -> Callable[[Scenario], Scenario]:
    """Changes keys of one section."""
    return lambda scenario: replace(
        scenario, **{section: replace(getattr(scenario, section), **keys)}
    )


def _proposed(scenario: Scenario) -> Scenario:
    """The scenario by the paper's method: MPC, modified model, weights by gamma."""
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


def _integral_best(scenario: Scenario) -> Scenario:
    integral, own = _integral(scenario), scenario.baseline
    weights = {field.name: getattr(own, field.name) for field in dataclasses.fields(own)}
    return replace(integral, mpc=replace(integral.mpc, **weights))


def _clik(scenario: Scenario) -> Scenario:
    """With a K_e that CLIK stands, since it believes the command."""
    k_e = tuple(min(gain, CLIK_MOST_K_E) for gain in scenario.mpc.k_e)
    own = _with("mpc", k_e=k_e)(_with_residual(scenario, "off"))
    return replace(own, controller="clik", orientation=OrientationOff())


PARTS: dict[str, Callable[[Scenario], Scenario]] = {
    "no_flight_model": lambda scenario: _with("model", kind=K_B_MODELS[scenario.flight.interface])(
        scenario
    ),
    "no_tilt": _with("mpc", tilt="none"),
    "no_feedforward": _with("flight", feedforward="none"),
    "short_horizon": _with("mpc", span_ticks=1),
    "no_filter": _with("filter", kind="none"),
}
"""The scenario without one of the parts that are not the paper's.

Which of them a scenario has, `parts` tells.
"""

VARIANTS: dict[str, Callable[[Scenario], Scenario]] = {
    "integral": _integral,
    "integral_best": _integral_best,
    "modified": lambda scenario: _with_residual(scenario, "off"),
    "modified+offline": lambda scenario: _with_residual(scenario, "offline"),
    "modified+online": lambda scenario: _with_residual(scenario, "online"),
    "clik": _clik,
    "fixed_weights": _with("allocation", kind="fixed"),
    **PARTS,
}
"""What each variant makes of the scenario by the paper's method.

`integral` believes the command, `integral_best` does with the weights of the
section `baseline`. `modified` has the scenario's own model without a residual,
`+offline` with its network as it is, `+online` with one that learns. `clik` is
closed-loop inverse kinematics, with K_e bounded and without orientation task;
`fixed_weights` the scenario without allocation. The rest is the scenario without one of `PARTS`.
"""

OWN_VARIANT = {"off": "modified", "offline": "modified+offline", "online": "modified+online"}
"""Which variant is the scenario by the paper's method, by its residual's mode."""


def make_variant(scenario: Scenario, name: str) -> Scenario:
    """One variant of a scenario, unchecked."""
    return VARIANTS[name](_proposed(scenario))


def make_variants(scenario: Scenario, names: Sequence[str] = ()) -> dict[str, Scenario]:
    """Variants of a scenario, by name, in the order of `VARIANTS`.

    Args:
        scenario: Whose variants they are.
        names: Which of them; none for all, but those without parts that it has not.

    Raises:
        BadInput: if one is unknown, or cannot be flown.
    """
    for name in names:
        if name not in VARIANTS:
            raise BadInput("--variant", "", f"no such variant '{name}'; {nearest(name, VARIANTS)}")
    vehicle = VehicleModel.load(scenario)
    for name in ("w_2_joints", "w_3_joints"):
        vehicle.per_joint(getattr(scenario.baseline, name), f"baseline.{name}")
    absent = PARTS.keys() - parts(_proposed(scenario))
    chosen = [name for name in VARIANTS if name in names or not names and name not in absent]
    variants = {name: make_variant(scenario, name) for name in chosen}
    for name, variant in variants.items():
        check(variant, f"{scenario.source} as {name}")
        make_closed_loop(variant)  # Reads the files it names; said now, not by a process.
    return variants


def parts(scenario: Scenario) -> list[str]:
    """The keys of `PARTS` that change how a scenario is flown."""
    is_here = {
        "no_flight_model": scenario.model.kind == "flight",
        "no_tilt": scenario.mpc.tilt != "none",
        "no_feedforward": scenario.flight.feedforward != "none",
        "short_horizon": scenario.mpc.span_ticks > scenario.mpc.horizon,
        "no_filter": scenario.filter.kind != "none" and not is_exact(scenario.sensors),
    }
    return [name for name in PARTS if is_here[name]]


def notes(scenario: Scenario) -> list[str]:
    """What should be known of a scenario's comparison."""
    if scenario.residual.checkpoint:
        return []
    return [
        "residual.checkpoint names no network, so that modified+offline is the same as modified, "
        "and modified+online learns from nothing"
    ]


def compare(
    variants: Mapping[str, Scenario],
    folder: Path,
    jobs: int,
    progress: Callable[[str], None] = lambda name: None,
) -> dict[str, dict[str, Any]]:
    """Flies each variant in a process of its own, into a folder of its name.

    Args:
        variants: By name.
        folder: Where their folders are made.
        jobs: How many processes at a time.
        progress: Called with the name of each variant that has ended.

    Returns:
        The summary of each, in their order; of one whose process raised or died,
        `exit_reason` failed and `exit_cause` alone. It leaves no folder.

    Raises:
        OSError: if a folder cannot be written.
    """
    names = list(variants)
    outcomes: dict[str, dict[str, Any]] = {}
    flights = [(variants[name], folder / name) for name in names]
    for index, outcome in run_parallel(_fly, flights, jobs):
        name = names[index]
        if isinstance(outcome, OSError | BadInput):
            raise outcome  # No fault of the variant's: there is no room to write it, say.
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
