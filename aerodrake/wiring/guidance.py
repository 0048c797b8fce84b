"""Wiring of guidance: the reference, its faults and its guard."""

from pydrake.systems.framework import Diagram

from aerodrake.model.mpc.horizon import stage_times
from aerodrake.model.reference.curves import make_reference
from aerodrake.model.reference.envelope import Envelope
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import ReferenceFault, Scenario
from aerodrake.support.arguments import checked
from aerodrake.support.errors import file_at
from aerodrake.systems.faults.reference import ReferenceFaultSystem
from aerodrake.systems.reference import ReferenceSystem
from aerodrake.systems.reference_guard import ReferenceGuard
from aerodrake.wiring.replacements import Replacements
from aerodrake.wiring.table import Wiring, outputs

WIRING = Wiring(
    connections=(("reference", "horizon", "reference_guard", "horizon"),),
    outputs=(
        *outputs("reference", "d_g"),
        ("reference", "reference", "requested_reference"),
        *outputs("reference_guard", "reference", "horizon", "reference_verdict"),
    ),
)


@checked
def make_guidance(
    scenario: Scenario, vehicle: VehicleModel, replacements: Replacements | None = None
) -> Diagram:
    """Makes guidance: the scenario's reference, its faults, and the guard that limits it.

    Outputs: `reference` (6) and `horizon` (6 (N + 1)), p_Ed, p_Ed' in m and m/s, now and at
    each stage, always within the envelope; `requested_reference` (6), now, as the reference
    has it before faults and guard; `d_g` (1) m; `reference_verdict` (1).
    """
    period = scenario.rates.mpc_period_s
    stages_s = stage_times(scenario.mpc, period)
    with file_at(scenario.source, "reference.file"):
        curve = make_reference(scenario.reference, vehicle.p_E)
    builder = (replacements or Replacements()).builder()
    builder.AddNamedSystem(
        "reference", ReferenceSystem(curve, vehicle.p_E, scenario.settle_s, stages_s)
    )
    envelope = Envelope.make(scenario.supervisor, vehicle.p_E)
    guard = ReferenceGuard(envelope, vehicle.p_E, scenario.mpc.horizon, period)
    builder.AddNamedSystem("reference_guard", guard)
    wiring = WIRING
    if any(isinstance(fault, ReferenceFault) for fault in scenario.faults):
        faulty = ReferenceFaultSystem(scenario.faults, scenario.settle_s, stages_s)
        builder.AddNamedSystem("reference_fault", faulty)
        wiring = WIRING.insert("reference_fault", ("reference", "horizon"), "horizon", "horizon")
    return wiring.build(builder, "guidance")
