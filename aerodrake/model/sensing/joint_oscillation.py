"""Detection of joints that oscillate about their setpoints, from the samples of their rates."""

from typing import NamedTuple, Self

import numpy as np

from aerodrake.model.sensing.sample import JOINTS, group_of
from aerodrake.model.sensing.sample_check import SampleCheck
from aerodrake.model.sensing.sample_health import Verdict, is_accepted
from aerodrake.support.compiled import compiled

LONGEST_S = 0.25
"""Duration of a half-wave beyond which it is no oscillation: that of 2 Hz."""

GROWTH = 20.0
"""Largest growth of an oscillation from one half-wave to the next."""

RELEASE = 0.2
"""Largest relative decrease of the amplitude at a sample that is not rejected as a jump."""

STEP_RAD = 0.03
"""Tolerated deviation of a joint's step from the mean of its rates at both ends."""


class JointOscillation(NamedTuple):
    """State of the detection after a sample: the last half-waves of each joint.

    A half-wave lasts while a joint's rate error, its measured rate less that of its setpoint, has
    one sign. Four consecutive half-waves of `LONGEST_S` or less are an oscillation. With their
    peaks p_0 (the latest) to p_3 and G = `GROWTH`, its amplitude is min(p_0, p_1, G p_2, G^2 p_3):
    a single push has small p_2 and p_3, and is no oscillation. An unstable joint is detected within
    few samples, before its rates are implausible and their samples rejected.

    Attributes:
        peaks: (5, n) rad/s, largest absolute rate error of each half-wave, the present one first.
        sign: (n,) sign of the present half-wave; 0 before the first.
        duration_s: (n,) s, duration of the present half-wave until now.
        amplitude: (n,) rad/s, amplitude of each joint's oscillation.
    """

    peaks: np.ndarray
    sign: np.ndarray
    duration_s: np.ndarray
    amplitude: np.ndarray

    @classmethod
    def none(cls, joints: int) -> Self:
        """Returns the state without oscillation."""
        return cls(np.zeros((5, joints)), np.zeros(joints), np.zeros(joints), np.zeros(joints))


@compiled
def track(
    last: JointOscillation,
    previous: np.ndarray,
    sample: np.ndarray,
    verdict: float,
    joint_setpoint: np.ndarray,
    bounds: SampleCheck,
) -> JointOscillation:
    """Returns the state after one more sample.

    A sample that is rejected as a jump counts if the step of the joints' angles from the previous
    one agrees with their rates. The amplitude does not decrease at samples that are rejected as
    jumps, and by `RELEASE` at most at each other one, since one may be accepted by chance.

    Args:
        last: State after the previous sample.
        previous, sample: (13 + 2 n,) as they arrived.
        verdict: `Verdict` on the joints of the sample.
        joint_setpoint: (3 n,) q_d, q_d', q_d'' in rad, rad/s, rad/s^2.
        bounds: Time between samples, and bound of the noise on the rates, by which rate errors are
            reduced.
    """
    n, dt, noise = len(last.sign), bounds.dt, bounds.rate_noise[JOINTS]
    peaks, sign = last.peaks.copy(), last.sign.copy()
    duration_s, amplitude = last.duration_s.copy(), last.amplitude.copy()
    q_previous, qdot_previous = group_of(JOINTS, previous)
    q, qdot = group_of(JOINTS, sample)
    is_jump = verdict == Verdict.JUMP.value
    is_motion = is_accepted(verdict)
    if is_jump:
        step = q - q_previous - dt / 2 * (qdot + qdot_previous)
        is_motion = np.abs(step).max() <= STEP_RAD
    for i in range(n):
        error = qdot[i] - joint_setpoint[n + i] if is_motion else 0.0
        error = np.sign(error) * max(abs(error) - noise, 0.0)
        if error * sign[i] < 0 or sign[i] == 0:
            for k in range(4, 0, -1):
                peaks[k, i] = peaks[k - 1, i]
            peaks[0, i], sign[i], duration_s[i] = 0.0, np.sign(error), 0.0
        peaks[0, i] = max(peaks[0, i], abs(error))
        duration_s[i] += dt
        if duration_s[i] > LONGEST_S + dt / 2:
            peaks[:, i] = 0.0
        # The present half-wave may not have reached its peak yet.
        amplitude[i] *= 1.0 if is_jump else 1.0 - RELEASE
        now = max(_amplitude(peaks[:4, i]), _amplitude(peaks[1:, i]))
        amplitude[i] = max(amplitude[i], now)
    return JointOscillation(peaks, sign, duration_s, amplitude)


@compiled
def _amplitude(peaks: np.ndarray) -> float:
    """Returns the amplitude of an oscillation with the peaks (4,) of its last half-waves."""
    return min(peaks[0], peaks[1], GROWTH * peaks[2], GROWTH**2 * peaks[3])
