"""Kalman filter that estimates the vehicle's present state from noisy, delayed samples."""

from typing import NamedTuple, Self

import numpy as np

from aerodrake.model.sensing.chain import Chain
from aerodrake.model.sensing.estimate import (
    Estimate,
    correct_acceleration,
    correct_attitude,
    correct_joints,
    correct_position,
    predict_arm,
    predict_base,
)
from aerodrake.model.sensing.joint_oscillation import JointOscillation, track
from aerodrake.model.sensing.sample import (
    ATTITUDE,
    JOINTS,
    POSITION,
    Sample,
    group_of,
    replace_group,
)
from aerodrake.model.sensing.sample_check import (
    CheckState,
    SampleCheck,
    check,
    has_begun,
    is_outage,
)
from aerodrake.model.sensing.sample_health import Verdict, is_accepted, split_health
from aerodrake.model.vehicle.state import split_state
from aerodrake.scenario import Filter, Sensors
from aerodrake.support.arguments import Period, checked
from aerodrake.support.compiled import compiled

JOINT_WALK_RAD = 1e-4
"""Standard deviation, per sample, of the joints' motion beyond their measured rates."""


NO_FORCE = np.full(3, np.nan)
"""Specific force without a new sample of the accelerometer."""


class StateFilter(NamedTuple):
    """Steady-state Kalman filters of the base's translation, its rotation, and the joints.

    Translation along each axis is the chain p' = v, v' = a + d, d' = noise, of which p and v
    are measured; a is the acceleration that the flight controller models. Rotation about each
    axis is the same chain, with attitude errors as rotation vectors in the base frame. Each
    joint is q' = q_m' + noise. The Riccati equation gives the gains once, from the scenario's
    noise. A group that is sampled less often than the filter ticks has the gains of its own
    period.

    An accelerometer measures d as well: its specific force less the modelled one. The gains are
    then those of the periodic Riccati equation, by the ticks since the last position.

    A delayed base sample corrects the estimate of its own time. The modelled accelerations
    since then predict the present.

    Attributes:
        translation: (3, 2) gains of [p, v, d] for [p, v] as measured.
        rotation: (3, 2) gains of [attitude, rate, delta] for [attitude, rate] as measured.
        accelerometer: (ticks, 3) gains of [p, v, d] for d as measured, by the ticks since the last
            position; (0, 3) without an accelerometer.
        joint: Gain of a joint's angle.
        check: Bounds for accepting a sample.
        steps: Assumed delay of the base's samples, in samples.
        dt: s, between samples.
    """

    translation: np.ndarray
    rotation: np.ndarray
    accelerometer: np.ndarray
    joint: float
    check: SampleCheck
    steps: int
    dt: float

    @classmethod
    @checked
    def make(cls, config: Filter, sensors: Sensors, dt: Period) -> Self:
        """Returns the filter for the noise, disturbances and delay that a scenario assumes.

        The actual noise and flaws of `sensors` only widen the bounds of the sample check, but for
        the periods of its groups; dt in s.
        """
        ticks = sensors.ticks(dt)
        base = Chain(config.position_noise_m, config.velocity_noise_m_s, config.disturbance_m_s3)
        turn = Chain(config.attitude_noise_rad, config.rate_noise_rad_s, config.disturbance_rad_s3)
        translation, accelerometer = base.gain(dt, ticks[POSITION]), np.empty((0, 3))
        if config.accelerometer_noise_m_s2 > 0:
            translation, accelerometer = base.periodic_gains(
                config.accelerometer_noise_m_s2, dt, ticks[POSITION]
            )
        r, q = config.joint_noise_rad**2, ticks[JOINTS] * JOINT_WALK_RAD**2
        P = (q + np.sqrt(q**2 + 4 * q * r)) / 2
        return cls(
            translation=translation,
            rotation=turn.gain(dt, ticks[ATTITUDE]),
            accelerometer=accelerometer,
            joint=float(P / (P + r)),
            check=SampleCheck.make(config, sensors, dt),
            steps=round(config.delay_s / dt),
            dt=dt,
        )


class FilterState(NamedTuple):
    """State of the filter.

    Attributes:
        check: State of the sample check.
        estimate: The base's part is at the time of its last sample; the joints' is at the
            last tick.
        accelerations: (steps, 6) modelled since the base's last sample, oldest first.
        position_offset: (3,) m, sum of the steps by which resets have moved the position.
        oscillation: Of the joints.
    """

    check: CheckState
    estimate: Estimate
    accelerations: np.ndarray
    position_offset: np.ndarray
    oscillation: JointOscillation

    @classmethod
    def at_rest(cls, gains: StateFilter, state: np.ndarray, trim_acceleration: np.ndarray) -> Self:
        """Returns the filter's state after a last sample one period before time 0.

        Args:
            gains: The filter.
            state: (13 + 2 n,) the vehicle's, at rest.
            trim_acceleration: (6,) modelled at rest; the initial disturbances cancel it.
        """
        return cls(
            CheckState.accepting(state, -gains.dt),
            Estimate(-trim_acceleration, state),
            np.tile(trim_acceleration, (gains.steps, 1)),
            np.zeros(3),
            JointOscillation.none(len(split_state(state).q)),
        )

    @classmethod
    def before_samples(
        cls, gains: StateFilter, state: np.ndarray, trim_acceleration: np.ndarray
    ) -> Self:
        """Returns the filter's state before the first sample, at time 0 or later.

        The first sample of each group replaces the estimate, whatever it is.

        Args:
            gains: The filter.
            state: (13 + 2 n,) estimate until then, at rest.
            trim_acceleration: (6,) as for `at_rest`.
        """
        at_rest = cls.at_rest(gains, state, trim_acceleration)
        return at_rest._replace(check=CheckState.initial(len(state), -gains.dt))


@compiled
def update(
    gains: StateFilter,
    last: FilterState,
    sample: Sample,
    acceleration: np.ndarray,
    joint_setpoint: np.ndarray,
    specific_force: np.ndarray,
) -> tuple[FilterState, Estimate]:
    """Corrects the estimate by the accepted groups of a sample, and predicts the others.

    The base is predicted by the modelled acceleration, the arm by its setpoints. The first
    accepted sample of a flight, after an outage or after a reset replaces the estimate and leaves
    the disturbances as they were: a correction would take the step for a disturbance.

    Args:
        gains: The filter.
        last: State of the filter.
        sample: The base's groups are delayed, the joints' are not.
        acceleration: (6,) modelled since the previous sample, as in `predict_base`.
        joint_setpoint: (3 n,) now.
        specific_force: (3,) m/s^2 in the base frame, measured mean over the period before the
            base's sample; `NO_FORCE` without a new one.

    Returns:
        The new state of the filter; the estimate of the present.
    """
    accelerations = np.concatenate((last.accelerations, acceleration[np.newaxis, :]))
    at_sample = predict_base(last.estimate, accelerations[0], gains.dt)
    predicted = predict_arm(at_sample, joint_setpoint, gains.dt)
    check_state = check(gains.check, last.check, predicted, sample)
    ages, verdicts = split_health(last.check.health).ages, split_health(check_state.health).verdicts
    position_offset = last.position_offset
    for g in range(3):
        is_reset = verdicts[g] == Verdict.RESET.value
        if is_reset:
            step = group_of(g, sample.state)[0] - group_of(g, at_sample.state)[0]
            position_offset = position_offset + step
        if not is_accepted(verdicts[g]):
            if g == JOINTS:
                replace_group(g, at_sample.state, predicted.state)
        elif is_reset or is_outage(gains.check, g, ages[g]) or not has_begun(g, last.check):
            replace_group(g, at_sample.state, sample.state)
        elif g == POSITION:
            correct_position(at_sample, sample.state, gains.translation)
        elif g == ATTITUDE:
            correct_attitude(at_sample, sample.state, gains.rotation)
        else:
            correct_joints(at_sample, sample.state, gains.joint, gains.dt)
    if len(gains.accelerometer) and np.all(np.isfinite(specific_force)):
        age = split_health(check_state.health).ages[POSITION]
        k = min(round(age / gains.dt), len(gains.accelerometer) - 1)
        gain = gains.accelerometer[k]
        correct_acceleration(at_sample, specific_force, accelerations[0], gain, gains.dt)
    now = at_sample
    for k in range(1, len(accelerations)):
        now = predict_base(now, accelerations[k], gains.dt)
    oscillation = track(
        last.oscillation,
        last.check.sample,
        sample.state,
        verdicts[JOINTS],
        joint_setpoint,
        gains.check,
    )
    new = FilterState(check_state, at_sample, accelerations[1:], position_offset, oscillation)
    return new, now


@compiled
def replace_rejected(sample: np.ndarray, predicted: np.ndarray, health: np.ndarray) -> np.ndarray:
    """Returns a sample (13 + 2 n,) whose rejected groups are those of `predicted` (13 + 2 n,).

    `health` (6,) is the sample's `SampleHealth`.
    """
    state = sample.copy()
    for g in range(3):
        if not is_accepted(split_health(health).verdicts[g]):
            replace_group(g, state, predicted)
    return state
