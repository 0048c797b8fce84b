"""Conditions under which the supervisor enters and leaves safe modes."""

from enum import IntEnum
from typing import NamedTuple, Self

import numpy as np

from aerodrake.model.reference.envelope import ReferenceVerdict
from aerodrake.model.residual.layer_gate import GateCause
from aerodrake.model.sensing.sample import ATTITUDE, JOINTS, POSITION
from aerodrake.model.sensing.sample_health import Verdict
from aerodrake.model.supervision.safe_mode import SafeMode
from aerodrake.model.vehicle.rotation import rotation_matrix
from aerodrake.model.vehicle.state import split_state
from aerodrake.scenario import Supervisor
from aerodrake.support.compiled import compiled

NEVER = np.inf
"""s, `Condition.clear_s` of a condition that never clears."""

NO_CAUSE = -1
"""Index of the cause while no condition is active."""

ON_GROUND_M = 0.003
"""Height of the feet at or below which they are on the ground, in NOMINAL and HOLD."""

LANDED_M, LANDED_THRUST_M_S2 = 0.08, 8.8
"""Largest height of the feet and largest thrust over mass of a landed, possibly tilted vehicle."""


class Signal(IntEnum):
    """Signals that conditions compare with thresholds. Flags are 0 or 1."""

    PLAN_AGE = 0  # Ticks since the MPC's last solution.
    PLAN_AGE_S = 1  # The same time in s.
    POSITION_OUTAGE = 2  # s since the last accepted sample of each group.
    ATTITUDE_OUTAGE = 3
    JOINTS_OUTAGE = 4  # 0 if samples are rejected because the joints oscillate.
    TILT = 5  # rad, of the base.
    ROTOR_LOSS = 6  # Largest fraction of its thrust that a rotor has lost.
    SATURATED = 7  # The flight controller is saturated.
    REFERENCE_NOT_FINITE = 8  # The reference guard's verdicts.
    REFERENCE_OUT_OF_REACH = 9
    REFERENCE_TOO_FAST = 10
    REFERENCE_JUMPED = 11
    LEARNER_GATED = 12  # A layer is gated off because it, or its training samples, were harmful.
    ON_GROUND = 13  # The feet are on the ground, in NOMINAL or HOLD.
    LANDED = 14  # In DESCEND the feet are near the ground, which bears part of the weight.
    GROUND_EXPECTED = 15  # In DESCEND, without position samples, the feet are predicted on it.
    NOT_FINITE = 16  # The state contains NaN or infinite values.
    POSITION_RESET = 17  # The filter starts again from a position that has jumped.
    JOINT_OSCILLATION = 18  # rad/s, largest amplitude of a joint.
    TORQUE_AT_LIMIT = 19  # The torque of a joint is at its limit.


SIGNALS = len(Signal)
"""S, the number of signals."""


class Condition(NamedTuple):
    """Requests a safe mode from when its signal triggers until it clears.

    Attributes:
        name: Name in events, summaries and reports.
        signal: The signal that is compared; NaN triggers.
        mode: The requested mode; NOMINAL only reports the condition.
        trigger: The condition triggers if the signal is at or above this value, in its unit,
            for `trigger_s`.
        trigger_s: s.
        clear: It clears if the signal is at or below this value for `clear_s`.
        clear_s: s; `NEVER` if the flight ends or lands.
        exit_reason: Exit reason of a flight that it stops.
    """

    name: str
    signal: Signal
    mode: SafeMode
    trigger: float
    trigger_s: float
    clear: float
    clear_s: float
    exit_reason: str = "stopped"


def conditions(config: Supervisor) -> tuple[Condition, ...]:
    """Returns all conditions; the first active one of the worst mode is the cause."""
    s, c, clear_s = Signal, config, config.clear_s
    report, hold, descend, stop = SafeMode  # NOMINAL only reports.
    fresh = min(1, c.plan_ticks - 1)  # A single missed tick does not count as an outage.
    lost = float(np.nextafter(1 - c.rotor_lost, 2))  # Strictly less thrust than `rotor_lost`.
    swing, unstable_s = c.joint_oscillation_rad_s, c.joints_unstable_s
    # name, signal, mode, triggers at or above, for s, clears at or below, for s
    return (
        Condition("not_finite", s.NOT_FINITE, stop, 1, 0, 0, NEVER, "lost"),
        Condition("tilt", s.TILT, stop, c.max_tilt_rad, 0, 0, NEVER, "lost"),
        Condition("rotor_lost", s.ROTOR_LOSS, stop, lost, 0, 0, NEVER),
        Condition("landed", s.LANDED, stop, 1, 0.3, 0, NEVER, "landed"),
        Condition("ground_expected", s.GROUND_EXPECTED, stop, 1, 0.5, 0, NEVER),
        Condition("ground_contact", s.ON_GROUND, stop, 1, 0.1, 0, NEVER),
        Condition("position_outage", s.POSITION_OUTAGE, hold, c.position_outage_s, 0, 0, clear_s),
        Condition("position_lost", s.POSITION_OUTAGE, descend, c.position_lost_s, 0, 0, NEVER),
        Condition("attitude_outage", s.ATTITUDE_OUTAGE, hold, c.attitude_outage_s, 0, 0, clear_s),
        Condition("attitude_lost", s.ATTITUDE_OUTAGE, stop, c.attitude_lost_s, 0, 0, NEVER),
        Condition("joints_outage", s.JOINTS_OUTAGE, hold, c.joints_outage_s, 0, 0, clear_s),
        Condition("joints_lost", s.JOINTS_OUTAGE, descend, c.joints_lost_s, 0, 0, NEVER),
        Condition("plan_lost", s.PLAN_AGE_S, descend, c.plan_lost_s, 0, 0, NEVER),
        Condition("plan_outage", s.PLAN_AGE, hold, c.plan_ticks, 0, fresh, clear_s),
        Condition("reference_not_finite", s.REFERENCE_NOT_FINITE, hold, 1, 0.1, 0, clear_s),
        Condition("reference_out_of_reach", s.REFERENCE_OUT_OF_REACH, hold, 1, 0.1, 0, clear_s),
        Condition("reference_too_fast", s.REFERENCE_TOO_FAST, hold, 1, 0.1, 0, clear_s),
        Condition("reference_jump", s.REFERENCE_JUMPED, report, 1, 0, 0, clear_s),
        Condition("learner_shut_out", s.LEARNER_GATED, report, 1, 0, 0, clear_s),
        Condition("rotor_degraded", s.ROTOR_LOSS, report, 0.1, 0.5, 0.05, clear_s),
        Condition("saturated", s.SATURATED, report, 1, 0.3, 0, clear_s),
        Condition("position_reset", s.POSITION_RESET, report, 1, 0, 0, clear_s),
        # Ends an oscillation whose loop includes the MPC, since the setpoints come to rest.
        Condition("joint_oscillation", s.JOINT_OSCILLATION, hold, swing, 0.1, swing / 2, clear_s),
        # The joints oscillate about setpoints at rest: no setpoint stops them.
        Condition("joints_unstable", s.JOINT_OSCILLATION, descend, swing, unstable_s, 0, NEVER),
        Condition("torque_at_limit", s.TORQUE_AT_LIMIT, report, 1, 0.3, 0, clear_s),
    )


class ConditionTable(NamedTuple):
    """Columns of K conditions as arrays (K,), for compiled code.

    Attributes:
        signal, mode: (K,) values of `Signal` and `SafeMode`.
        trigger, clear: (K,) thresholds in the signal's unit.
        trigger_s, clear_s: (K,) s.
    """

    signal: np.ndarray
    mode: np.ndarray
    trigger: np.ndarray
    trigger_s: np.ndarray
    clear: np.ndarray
    clear_s: np.ndarray

    @classmethod
    def make(cls, conditions: tuple[Condition, ...]) -> Self:
        """Returns the columns of conditions."""
        columns = zip(*(condition[1:7] for condition in conditions), strict=True)
        signal, mode, *others = (np.array(column, dtype=float) for column in columns)
        return cls(signal.astype(np.int64), mode.astype(np.int64), *others)


class SupervisorState(NamedTuple):
    """State of the supervisor after a sample.

    Attributes:
        mode: The worst `SafeMode` that an active condition requests.
        cause: Index of the first condition that requests it, or `NO_CAUSE`.
        active: (K,) 1 for active conditions.
        pending_s: (K,) s, time for which each signal has met the threshold that changes
            its condition.
    """

    mode: int
    cause: int
    active: np.ndarray
    pending_s: np.ndarray

    @classmethod
    def initial(cls, count: int) -> Self:
        """Returns the state in NOMINAL, with none of `count` conditions active."""
        return cls(int(SafeMode.NOMINAL), NO_CAUSE, np.zeros(count), np.zeros(count))


@compiled
def supervise(
    table: ConditionTable, state: SupervisorState, signals: np.ndarray, dt: float
) -> SupervisorState:
    """Returns the supervisor's state after one more sample.

    Args:
        table: K conditions.
        state: State after the sample before.
        signals: (S,) values at this sample, by `Signal`.
        dt: s, between samples.
    """
    active, pending_s = state.active.copy(), state.pending_s.copy()
    mode, cause = SafeMode.NOMINAL.value, NO_CAUSE
    for i in range(len(active)):
        value = signals[table.signal[i]]
        if active[i]:
            is_met, after_s = value <= table.clear[i], table.clear_s[i]
        else:  # `not <` also holds for NaN.
            is_met, after_s = not value < table.trigger[i], table.trigger_s[i]
        # Half a sample of tolerance: rounding must not cost a whole one.
        if is_met and pending_s[i] >= after_s - dt / 2:
            active[i], pending_s[i] = 1.0 - active[i], 0.0
        else:
            pending_s[i] = pending_s[i] + dt if is_met else 0.0
        is_first = cause == NO_CAUSE and table.mode[i] == mode
        if active[i] and (table.mode[i] > mode or is_first):
            mode, cause = table.mode[i], i
    return SupervisorState(mode, cause, active, pending_s)


class FlightStatus(NamedTuple):
    """Quantities from which the signals are computed.

    Attributes:
        state: (13 + 2 n,) measured state.
        mode: The `SafeMode` until now.
        specific_thrust: m/s^2, estimated thrust of all rotors over the mass.
        plan_age: Ticks since the MPC's last solution.
        outage_s: (3,) s since the last accepted sample of position, attitude, and joints.
        verdicts: (3,) the `Verdict` on each of them.
        joint_oscillation: (n,) rad/s, amplitude with which each joint oscillates.
        torque_at_limit: (n,) 1 for each joint whose torque is at its limit.
        rotor_effectiveness: (k,) fraction of its thrust that each rotor gives.
        saturated: 1 while the flight controller is saturated.
        reference_verdict: A `ReferenceVerdict`.
        learner_cause: The `GateCause` for which the residual's layer is gated off, or OK.
    """

    state: np.ndarray
    mode: int
    specific_thrust: float
    plan_age: float
    outage_s: np.ndarray
    verdicts: np.ndarray
    joint_oscillation: np.ndarray
    torque_at_limit: np.ndarray
    rotor_effectiveness: np.ndarray
    saturated: float
    reference_verdict: float
    learner_cause: float


@compiled
def compute_signals(
    status: FlightStatus, feet: float, mpc_period: float, oscillation: float
) -> np.ndarray:
    """Returns the values (S,) of all signals, by `Signal`.

    Args:
        status: Quantities at this sample.
        feet: m, z of the vehicle's lowest point in the base frame.
        mpc_period: s, between ticks of the MPC.
        oscillation: rad/s, least amplitude of an oscillation that may be why samples of the
            joints are rejected.
    """
    quaternion, p_B, _, _, _, _ = split_state(status.state)
    is_finite = np.all(np.isfinite(status.state))
    tilt = np.arccos(min(1.0, max(-1.0, rotation_matrix(quaternion)[2, 2])))
    height = p_B[2] + feet if is_finite else np.inf
    has_landed = height <= LANDED_M and status.specific_thrust <= LANDED_THRUST_M_S2
    is_descending = status.mode >= SafeMode.DESCEND.value
    # A predicted position does not stop at the ground.
    is_predicted = status.outage_s[POSITION] > 0
    swing = status.joint_oscillation.max()
    # Joints that oscillate accelerate beyond what is plausible.
    is_motion = swing >= oscillation and status.verdicts[JOINTS] == Verdict.JUMP.value
    verdict = status.reference_verdict
    values = np.zeros(SIGNALS)
    values[Signal.PLAN_AGE.value] = status.plan_age
    values[Signal.PLAN_AGE_S.value] = status.plan_age * mpc_period
    values[Signal.POSITION_OUTAGE.value] = status.outage_s[POSITION]
    values[Signal.ATTITUDE_OUTAGE.value] = status.outage_s[ATTITUDE]
    values[Signal.JOINTS_OUTAGE.value] = 0.0 if is_motion else status.outage_s[JOINTS]
    values[Signal.TILT.value] = tilt if is_finite else 0.0
    values[Signal.ROTOR_LOSS.value] = 1.0 - status.rotor_effectiveness.min()
    values[Signal.SATURATED.value] = status.saturated
    values[Signal.REFERENCE_NOT_FINITE.value] = verdict == ReferenceVerdict.NOT_FINITE.value
    values[Signal.REFERENCE_OUT_OF_REACH.value] = verdict == ReferenceVerdict.OUT_OF_REACH.value
    values[Signal.REFERENCE_TOO_FAST.value] = verdict == ReferenceVerdict.TOO_FAST.value
    values[Signal.REFERENCE_JUMPED.value] = verdict == ReferenceVerdict.JUMPED.value
    # UNPROVEN, the lowest cause, is no harm: the layer has yet to improve predictions.
    values[Signal.LEARNER_GATED.value] = status.learner_cause > GateCause.UNPROVEN.value
    values[Signal.ON_GROUND.value] = not is_descending and height <= ON_GROUND_M
    values[Signal.LANDED.value] = is_descending and not is_predicted and has_landed
    values[Signal.GROUND_EXPECTED.value] = is_descending and is_predicted and height <= 0
    values[Signal.NOT_FINITE.value] = not is_finite
    values[Signal.POSITION_RESET.value] = status.verdicts[POSITION] == Verdict.RESET.value
    values[Signal.JOINT_OSCILLATION.value] = swing
    values[Signal.TORQUE_AT_LIMIT.value] = status.torque_at_limit.max()
    return values
