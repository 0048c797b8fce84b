"""Where the end-effector is to be, as a diagram: the reference, and what of it is followed."""

from __future__ import annotations

from pydrake.systems.framework import Diagram

from aerodrake.model.mpc.horizon import stage_times
from aerodrake.model.reference.curves import make_reference
from aerodrake.model.reference.envelope import Envelope
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import REFERENCE_FAULTS, Scenario
from aerodrake.support.errors import file_at
from aerodrake.systems.faults.reference import ReferenceFaultSystem
from aerodrake.systems.reference import ReferenceSystem
from aerodrake.systems.reference_guard import ReferenceGuard
from aerodrake.wiring.replacements import Replacements


def make_guidance(
    scenario: Scenario, vehicle: VehicleModel, replacements: Replacements | None = None
) -> Diagram:
    """The scenario's reference, with the faults that it declares, within the envelope.

    Outputs: `reference` (6) and `horizon` (6 (N + 1)), p_Ed, p_Ed' in m and m/s, now and at
    each stage, always such that they can be followed; `d_g` (1) m; `reference_verdict` (1).
    """
    period = scenario.rates.mpc_period_s
    stages_s = stage_times(scenario.mpc, period)
    with file_at(scenario.source, "reference.file"):
        curve = make_reference(scenario.reference, vehicle.p_E)
    builder = (replacements or Replacements()).builder()
    reference = builder.AddNamedSystem(
        "reference", ReferenceSystem(curve, vehicle.p_E, scenario.settle_s, stages_s)
    )
    guard = builder.AddNamedSystem(
        "reference_guard",
        ReferenceGuard(
            Envelope.make(scenario.supervisor, vehicle.p_E),
            vehicle.p_E,
            scenario.mpc.horizon,
            period,
        ),
    )
    asked = reference
    if any(isinstance(fault, REFERENCE_FAULTS) for fault in scenario.faults):
        asked = builder.AddNamedSystem(
            "reference_fault", ReferenceFaultSystem(scenario.faults, scenario.settle_s, stages_s)
        )
        builder.Connect(reference.GetOutputPort("horizon"), asked.GetInputPort("horizon"))
    builder.Connect(asked.GetOutputPort("horizon"), guard.GetInputPort("horizon"))
    builder.ExportOutput(reference.GetOutputPort("d_g"), "d_g")
    for port in ("reference", "horizon", "reference_verdict"):
        builder.ExportOutput(guard.GetOutputPort(port), port)
    diagram = builder.Build()
    diagram.set_name("guidance")
    return diagram
