"""State filter with sensors of other rates than its own, and with an accelerometer."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from aerodrake.model.sensing.sample import Sample
from aerodrake.model.sensing.sample_health import Verdict, split_health
from aerodrake.model.sensing.state_filter import NO_FORCE, FilterState, StateFilter, update
from aerodrake.model.vehicle.state import split_state
from aerodrake.scenario import Accelerometer, Filter, JointSensors, PositionSensor, Sensors
from tests.estimates import DT, JOINTS, rest

SLOW = PositionSensor(period_s=4 * DT)
D = np.array([1.5, -1.0, 0.5])


def errors(config: Filter, sensors: Sensors, samples: int, attitude: Rotation) -> np.ndarray:
    """Returns the error (samples, 3) of d, which steps from zero to `D` as the base starts.

    Positions are exact and arrive at every fourth tick.
    """
    quaternion = attitude.as_quat(scalar_first=True)
    gains, start = StateFilter.make(config, sensors, DT), rest(quaternion=quaternion)
    state, stamps = FilterState.at_rest(gains, start.to_vector(), np.zeros(6)), np.full(3, -DT)
    force = attitude.inv().apply(D + [0, 0, 9.81]) if len(gains.accelerometer) else NO_FORCE
    sample, off = start, []
    for k in range(1, samples + 1):
        t = k * DT
        stamps = np.array([stamps[0], t, t])
        if k % 4 == 0:
            sample, stamps = rest(quaternion=quaternion, p_B=D * t**2 / 2, v_B=D * t), np.full(3, t)
        measured = Sample(sample.to_vector(), stamps)
        state, now = update(gains, state, measured, np.zeros(6), np.zeros(3 * JOINTS), force)
        verdict = split_health(state.check.health).verdicts[0]
        assert verdict == (Verdict.STALE if k % 4 else Verdict.OK)
        off.append(now.disturbance[:3] - D)
    np.testing.assert_allclose(split_state(now.state).p_B, D * t**2 / 2, atol=0.01)
    return np.array(off)


@pytest.mark.parametrize("noise", [0.0, 0.2])
def test_a_constant_disturbance_is_estimated_from_rare_positions(noise):
    config = Filter(accelerometer_noise_m_s2=noise, disturbance_m_s3=2.0)
    sensors = Sensors(position=SLOW, accelerometer=Accelerometer(period_s=DT))
    off = errors(config, sensors, 400, Rotation.from_euler("xyz", [0.3, -0.2, 0.5]))
    np.testing.assert_allclose(off[-1], 0, atol=1e-3)


def test_an_accelerometer_finds_a_disturbance_sooner():
    sensors = Sensors(position=SLOW, accelerometer=Accelerometer(period_s=DT))
    level = Rotation.identity()
    off = [
        np.linalg.norm(errors(Filter(accelerometer_noise_m_s2=noise), sensors, 40, level)[-1])
        for noise in (0.0, 0.05)
    ]
    assert off[1] < off[0] / 3


def test_slow_joints_have_the_gain_of_their_own_period():
    gain = [
        StateFilter.make(Filter(), Sensors(joints=JointSensors(period_s=period)), DT).joint
        for period in (0.0, DT / 2, DT, 4 * DT)
    ]
    assert gain[0] == gain[1] == gain[2] < gain[3]
