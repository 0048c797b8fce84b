"""Made-up logs of flights whose figures are known."""

import json
import math

import numpy as np

from aerodrake.flight.log import FlightLog
from aerodrake.flight.summary import summarize, to_json
from aerodrake.model.mpc.weight_allocation import Mode
from aerodrake.model.qp.result import QpStatus
from aerodrake.model.reference.curves import make_reference
from aerodrake.model.reference.envelope import ReferenceVerdict
from aerodrake.model.reference.reference_curve import hover_then_follow
from aerodrake.model.supervision.conditions import conditions
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Clover, Scenario, Supervisor

VEHICLE = VehicleModel.load(Scenario())
PERIOD_S = 0.01
TICK_S = 0.02


CLOVER = Scenario(name="made", seed=5, reference=Clover(start_s=3, lap_s=24), settle_s=1)


def made(
    error=lambda t: np.zeros_like(t),
    base_error=lambda t: np.zeros_like(t),
    mode=lambda t: np.full_like(t, Mode.HOVER),
    *,
    settle_s=1.0,
    until_s=30.0,
    **others,
) -> FlightLog:
    """A log of `CLOVER` with the given errors in m and modes over reference time in s."""
    samples = round((settle_s + until_s) / PERIOD_S) + 1
    t = np.arange(samples) * PERIOD_S - settle_s
    t = np.round(t, 9)
    curve = make_reference(CLOVER.reference, VEHICLE.p_E)
    p_Ed, _ = hover_then_follow(curve, VEHICLE.p_E, t)
    diagonal = np.ones(3) / math.sqrt(3)  # An error has three components.
    signals = {
        "time_s": t,
        "p_Ed_m": p_Ed,
        "p_E_m": p_Ed + np.outer(error(t), diagonal),
        "p_Bd_m": np.zeros((samples, 3)),
        "p_B_m": np.outer(base_error(t), -diagonal),
        "quaternion": np.tile([1.0, 0, 0, 0], (samples, 1)),
        "q_rad": np.tile(Scenario().vehicle.working_rad, (samples, 1)),
        "tool_axis": np.tile([0.0, 0, -1.0], (samples, 1)),
        "tool_axis_d": np.zeros((samples, 3)),
        "mode": mode(t),
        "reference_verdict": np.full(samples, ReferenceVerdict.OK, float),
        "torque_at_limit": np.zeros((samples, VEHICLE.joints)),
        "supervisor_mode": np.zeros(samples),
        "conditions": np.zeros((samples, len(conditions(Supervisor())))),
        "qp_status": np.full(samples, QpStatus.UNCONSTRAINED, float),
        "prediction_error_m_s": np.zeros((samples, 3)),
        "nominal_prediction_error_m_s": np.zeros((samples, 3)),
        "tick_ms": np.full(math.ceil((samples - 1) * PERIOD_S / TICK_S), 1.0),
    }
    ending = {"exit_reason": "completed", "exit_cause": "", "wall_s": 4.0}
    for key in set(others) & set(ending):
        ending[key] = others.pop(key)
    return FlightLog(signals | others, vehicle=VEHICLE, **ending)


def figures(log: FlightLog, scenario: Scenario = CLOVER):
    return json.loads(to_json(summarize(scenario, log)))
