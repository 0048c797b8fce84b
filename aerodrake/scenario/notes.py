"""Notes on values of a scenario that are valid but may degrade the flight."""

from aerodrake.scenario.faults import LearnerFault, MpcStarved
from aerodrake.scenario.residual import Guards, Residual
from aerodrake.scenario.scenario import Scenario
from aerodrake.scenario.sections import Allocation


def value_notes(scenario: Scenario) -> list[str]:
    """Returns notes on values that are valid but may degrade the flight."""
    notes = []
    d_h, space = scenario.allocation.d_h_m, scenario.allocation.learning_space_m
    is_the_papers = (d_h, space) == (Allocation.d_h_m, Allocation.learning_space_m)
    if d_h > space[2] / 2 and not is_the_papers:
        notes.append(
            f"allocation.d_h_m ({d_h:g} m) exceeds half the height of the learning space "
            f"({space[2] / 2:g} m)"
        )
    if scenario.model.kind in ("paper", "exact") and scenario.flight.interface == "trajectory":
        notes.append(
            f"model.kind {scenario.model.kind} is for flight.interface position; with "
            "flight.interface trajectory it predicts a lag that the base does not have"
        )
    if scenario.mpc.tilt == "held":
        notes.append("mpc.tilt held, the paper's form, destabilises the loop at high gains")
    if scenario.residual.as_printed:
        notes += [
            f"residual.as_printed: residual.{key} is not used"
            for key in Guards._fields
            if getattr(scenario.residual, key)
            not in (getattr(Residual, key), getattr(Guards(), key))
        ]
    if scenario.residual.mode == "off":
        notes += [
            f"faults[{i}] {fault.kind} has no effect: residual.mode off has no learner"
            for i, fault in enumerate(scenario.faults)
            if isinstance(fault, LearnerFault)
        ]
    if (solver := scenario.mpc.solver) not in ("osqp", "active_set"):
        notes += [
            f"faults[{i}] {fault.kind}: mpc.solver {solver} has its own limit of iterations"
            for i, fault in enumerate(scenario.faults)
            if isinstance(fault, MpcStarved)
        ]
    return notes
