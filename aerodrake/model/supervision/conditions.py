"""What is watched on a flight, when that asks for a safe mode, and when it no longer does."""

from __future__ import annotations

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from aerodrake.model.residual.judge import Cause
from aerodrake.model.supervision.safe_mode import SafeMode
from aerodrake.model.vehicle.rotation import rotation_matrix
from aerodrake.model.vehicle.state import split_state
from aerodrake.scenario import Supervisor
from aerodrake.support.compiled import compiled

NEVER = np.inf
"""s: what lasts for so long is never cleared."""

UNPROVEN = int(Cause.UNPROVEN)
"""What has yet to show that it helps has done no harm."""

ON_GROUND_M = 0.003
"""Feet that are as low as this are on the ground."""

LANDED_M, LANDED_THRUST_M_S2 = 0.08, 8.8
"""Feet that may be on it, tilted as they are, where less thrust than this holds the vehicle."""


class Signal(IntEnum):
    """What conditions look at."""

    PLAN_AGE = 0  # Ticks since the MPC's last answer.
    PLAN_AGE_S = 1  # The same in s.
    POSITION_OUTAGE = 2  # s since the last sample that was taken in, of each group.
    ATTITUDE_OUTAGE = 3
    JOINTS_OUTAGE = 4
    TILT = 5  # rad, of the base.
    ROTOR_MISSING = 6  # Largest share of its thrust that a rotor does not give.
    SATURATED = 7  # 1 while the flight controller is.
    REFERENCE_NOT_FINITE = 8  # 1 while the reference is.
    REFERENCE_OUT_OF_REACH = 9
    REFERENCE_TOO_FAST = 10
    REFERENCE_JUMPED = 11
    LEARNER_SHUT_OUT = 12  # 1 while what was learned is not used, since it did harm.
    ON_GROUND = 13  # 1 while the feet are, in NOMINAL or HOLD.
    LANDED = 14  # 1 while they are near it in DESCEND, and it carries part of the weight.
    GROUND_EXPECTED = 15  # 1 while they are to be on it in DESCEND, by prediction alone.
    NOT_FINITE = 16  # 1 while the state is not.


class Condition(NamedTuple):
    """A signal that asks for a mode from when it triggers until it is cleared.

    Attributes:
        name: Of it, as a cause.
        signal: What it looks at. One that is no number triggers.
        mode: What it asks for; NOMINAL for nothing but to be known.
        trigger: It triggers at this value, in the signal's unit, or above,
        trigger_s: for so long.
        clear: It clears at this value, alike, or below,
        clear_s: for so long; `NEVER` where a landing or a stop is for good.
        exit_reason: How a flight ends that it stops.
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
    """All of them; of several that ask for the same mode the first is the cause."""
    hold, descend, stop, known = (
        SafeMode.HOLD,
        SafeMode.DESCEND,
        SafeMode.STOP,
        SafeMode.NOMINAL,
    )
    s, clear_s = Signal, config.clear_s
    # An answer may take its period, and now and then one is missed.
    fresh = min(1, config.plan_ticks - 1)
    missing = float(np.nextafter(1 - config.rotor_lost, 2))  # Less than the share is left.
    outages = [
        condition
        for group, ride_s, lost_s, lost in (
            ("position", config.position_outage_s, config.position_lost_s, descend),
            ("attitude", config.attitude_outage_s, config.attitude_lost_s, stop),
            ("joints", config.joints_outage_s, config.joints_lost_s, descend),
        )
        for signal in (s[f"{group.upper()}_OUTAGE"],)
        for condition in (
            Condition(f"{group}_outage", signal, hold, ride_s, 0, 0, clear_s),
            Condition(f"{group}_lost", signal, lost, lost_s, 0, 0, NEVER),
        )
    ]
    return (
        Condition("not_finite", s.NOT_FINITE, stop, 1, 0, 0, NEVER, "lost"),
        Condition("tilt", s.TILT, stop, config.max_tilt_rad, 0, 0, NEVER, "lost"),
        Condition("rotor_lost", s.ROTOR_MISSING, stop, missing, 0, 0, NEVER),
        Condition("landed", s.LANDED, stop, 1, 0.3, 0, NEVER, "landed"),
        Condition("ground_expected", s.GROUND_EXPECTED, stop, 1, 0.5, 0, NEVER),
        Condition("ground_contact", s.ON_GROUND, stop, 1, 0.1, 0, NEVER),
        *outages,
        Condition("plan_lost", s.PLAN_AGE_S, descend, config.plan_lost_s, 0, 0, NEVER),
        Condition("plan_outage", s.PLAN_AGE, hold, config.plan_ticks, 0, fresh, clear_s),
        Condition("reference_not_finite", s.REFERENCE_NOT_FINITE, hold, 1, 0.1, 0, clear_s),
        Condition("reference_out_of_reach", s.REFERENCE_OUT_OF_REACH, hold, 1, 0.1, 0, clear_s),
        Condition("reference_too_fast", s.REFERENCE_TOO_FAST, hold, 1, 0.1, 0, clear_s),
        Condition("reference_jump", s.REFERENCE_JUMPED, known, 1, 0, 0, clear_s),
        Condition("learner_shut_out", s.LEARNER_SHUT_OUT, known, 1, 0, 0, clear_s),
        Condition("rotor_degraded", s.ROTOR_MISSING, known, 0.1, 0.5, 0.05, clear_s),
        Condition("saturated", s.SATURATED, known, 1, 0.3, 0, clear_s),
    )


class Rules(NamedTuple):
    """Conditions as arrays, a row for each of K, for `supervise`.

    Attributes:
        signal: (K,), what each looks at, by its number.
        mode: (K,), a `SafeMode` each.
        trigger, clear: (K,), in the signal's unit.
        trigger_s, clear_s: (K,) s.
    """

    signal: np.ndarray
    mode: np.ndarray
    trigger: np.ndarray
    trigger_s: np.ndarray
    clear: np.ndarray
    clear_s: np.ndarray

    @classmethod
    def of(cls, conditions: tuple[Condition, ...]) -> Rules:
        """The numbers of conditions."""
        columns = zip(*(condition[1:7] for condition in conditions), strict=True)
        signal, mode, *others = (np.array(column, dtype=float) for column in columns)
        return cls(signal.astype(np.int64), mode, *others)


@compiled
def supervise(
    rules: Rules, active: np.ndarray, since: np.ndarray, signals: np.ndarray, dt: float
) -> tuple[float, float, np.ndarray, np.ndarray]:
    """One sample of supervision.

    Args:
        rules: K of them.
        active: (K,) 1 where a condition is, as after the sample before.
        since: (K,) s for which its signal has asked for the contrary.
        signals: (S,) now.
        dt: s, between samples.

    Returns:
        mode, the worst that is asked for; cause, the index of the first condition that asks
        for it, -1 for none; active and since, as after this sample.
    """
    active, since = active.copy(), since.copy()
    mode, cause = 0.0, -1.0
    for i in range(len(active)):
        value = signals[rules.signal[i]]
        if active[i]:
            is_contrary, after = value <= rules.clear[i], rules.clear_s[i]
        else:  # What is no number is never below.
            is_contrary, after = not value < rules.trigger[i], rules.trigger_s[i]
        # Half a sample of slack, lest rounding cost a whole one.
        if is_contrary and since[i] >= after - dt / 2:
            active[i], since[i] = 1.0 - active[i], 0.0
        else:
            since[i] = since[i] + dt if is_contrary else 0.0
        if active[i] and (rules.mode[i] > mode or cause < 0 and rules.mode[i] == mode):
            mode, cause = rules.mode[i], float(i)
    return mode, cause, active, since


@compiled
def signals(
    state: np.ndarray,
    feet: float,
    mode: float,
    thrust: float,
    plan_age: float,
    period: float,
    outage: np.ndarray,
    effectiveness: np.ndarray,
    saturated: float,
    verdict: float,
    learner: float,
) -> np.ndarray:
    """(S,) what conditions look at, as `Signal` has it.

    Args:
        state: (13 + 2 n,) as measured.
        feet: m, z of the vehicle's lowest point in the base frame.
        mode: A `SafeMode`, until now.
        thrust: m/s^2, of all rotors over the mass, as believed.
        plan_age: Ticks since the MPC's last answer.
        period: s, between its ticks.
        outage: (3,) s since the last sample of position, attitude, and joints.
        effectiveness: (k,) share of its thrust that each rotor gives.
        saturated: 1 while the flight controller is.
        verdict: A `ReferenceVerdict`.
        learner: A `Cause` for which what was learned is not used.
    """
    quaternion, p_B, _, _, _, _ = split_state(state)
    is_finite = np.all(np.isfinite(state))
    tilt = np.arccos(min(1.0, max(-1.0, rotation_matrix(quaternion)[2, 2])))
    height = p_B[2] + feet if is_finite else np.inf
    found = np.zeros(17)
    found[0], found[1] = plan_age, plan_age * period
    found[2:5] = outage
    found[5] = tilt if is_finite else 0.0
    found[6] = 1.0 - effectiveness.min()
    found[7] = saturated
    for i in range(4):
        found[8 + i] = 1.0 if verdict == i + 1 else 0.0
    found[12] = 1.0 if learner > UNPROVEN else 0.0
    if mode < 1.5:  # NOMINAL, HOLD.
        found[13] = 1.0 if height <= ON_GROUND_M else 0.0
    elif outage[0] > 0:  # What is predicted knows of no ground.
        found[15] = 1.0 if height <= 0 else 0.0
    else:
        found[14] = 1.0 if height <= LANDED_M and thrust <= LANDED_THRUST_M_S2 else 0.0
    found[16] = 0.0 if is_finite else 1.0
    return found
