"""Detection of oscillating joints: amplitude, growth, and what is no oscillation."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aerodrake.model.sensing.joint_oscillation import LONGEST_S, RELEASE, JointOscillation, track
from aerodrake.model.sensing.sample import JOINTS as JOINT_GROUP
from aerodrake.model.sensing.sample_check import SampleCheck
from aerodrake.model.sensing.sample_health import Verdict
from aerodrake.model.vehicle.state import VehicleState, split_state
from aerodrake.scenario import Filter, JointSensors, Sensors

DT, JOINTS = 0.01, 3
BOUNDS = SampleCheck.make(Filter(), Sensors(), DT)
OK, JUMP = Verdict.OK, Verdict.JUMP


class Joints:
    """Samples of joints of which one moves at given rates, and the detection."""

    def __init__(self, joint: int = 1, bounds: SampleCheck = BOUNDS):
        self.joint, self.bounds = joint, bounds
        self.sample = np.zeros(VehicleState.size(JOINTS))
        self.setpoint = np.zeros(3 * JOINTS)
        self.state = JointOscillation.none(JOINTS)

    def move(self, *rates: float, verdict: Verdict = OK, offset: float = 0.0) -> float:
        """Returns the amplitude after samples in steps of the mean rates, with an offset."""
        for rate in rates:
            last, sample = split_state(self.sample), self.sample.copy()
            q, qdot = split_state(sample).q, split_state(sample).qdot
            q[self.joint] += DT / 2 * (last.qdot[self.joint] + rate) + offset
            qdot[self.joint] = rate
            arguments = self.sample, sample, float(verdict), self.setpoint, self.bounds
            self.state, self.sample = track(self.state, *arguments), sample
        return self.state.amplitude[self.joint]


@given(
    frequency_hz=st.floats(2.2, 48.0),
    growth_1_s=st.floats(-0.5, 30.0),
    setpoint=st.floats(-3.0, 3.0),
    joint=st.integers(0, JOINTS - 1),
)
def test_the_amplitude_of_a_sine_after_two_periods(frequency_hz, growth_1_s, setpoint, joint):
    """The tolerance covers the growth over a half-wave, and peaks between two samples."""
    joints = Joints(joint)
    joints.setpoint[JOINTS + joint] = setpoint
    times = np.arange(0.0, 2.2 / frequency_hz + 5 * DT, DT)
    sine = 0.8 * np.exp(growth_1_s * times) * np.sin(2 * np.pi * frequency_hz * times + 0.3)
    amplitude = joints.move(*(setpoint + sine))
    envelope = 0.8 * np.exp(growth_1_s * times[-1])
    last = np.exp(abs(growth_1_s) * (1.5 / frequency_hz + 2 * DT))
    between = np.cos(min(np.pi * frequency_hz * DT, 1.45)) if frequency_hz < 25 else 0.05
    assert between * envelope / last <= amplitude <= envelope * last + 1e-12
    others = np.delete(joints.state.amplitude, joint)
    np.testing.assert_array_equal(others, 0.0)


def test_growth_by_a_factor_of_ten_each_sample_is_detected_at_once():
    """The rates are of an unstable joint loop; the last sample is rejected as a jump."""
    joints = Joints()
    assert joints.move(0.001, -0.012, 0.12, -1.3) < 0.2
    assert joints.move(13.0, verdict=JUMP) == 1.3


def test_the_amplitude_stays_while_samples_are_rejected_as_jumps():
    joints = Joints()
    joints.move(*[2.0, -2.0] * 4)
    assert joints.move(*[9.0] * 100, verdict=JUMP) == 2.0
    assert joints.move(0.0) == pytest.approx(2.0 * (1 - RELEASE))
    assert joints.move(*[9.0] * 100, verdict=JUMP) == pytest.approx(2.0 * (1 - RELEASE))
    assert joints.move(*[0.0] * 30) < 0.01


def test_a_return_from_a_drift_during_an_outage_is_no_oscillation():
    """Rejected samples of angles with an offset, then sound ones and feedback again."""
    joints = Joints()
    joints.move(*[0.01, -0.01] * 4)
    joints.move(0.0, verdict=JUMP, offset=0.5)
    drift = joints.move(*np.linspace(0.0, -1.7, 50), verdict=JUMP)
    back = [joints.move(rate) for rate in (-1.0, 1.0, 3.0, 3.0, 2.0, 0.5, -0.1)]
    assert max(drift, *back) <= 0.2


@pytest.mark.parametrize("verdict", [Verdict.STALE, Verdict.FROZEN, Verdict.NOT_FINITE])
def test_missing_samples_end_an_oscillation(verdict):
    joints = Joints()
    joints.move(*[2.0, -2.0] * 4)
    assert joints.move(*[np.nan] * (2 * round(LONGEST_S / DT) + 1), verdict=verdict) < 0.01


@given(
    noise=st.lists(st.floats(-0.02, 0.02), min_size=4, max_size=40),
    jump=st.floats(0.1, 1.0),
    period=st.integers(1, 4),
)
def test_angles_that_jump_are_no_oscillation(noise, jump, period):
    """The angles jump to and fro, and the rates do not agree with them."""
    joints = Joints()
    for k, rate in enumerate(noise):
        offset = jump * (-1) ** (k // period) if k % period == 0 else 0.0
        assert joints.move(rate, verdict=JUMP if offset else OK, offset=offset) <= 0.02


@given(push=st.floats(0.3, 20.0), noise=st.floats(0.0, 0.01), damping=st.floats(0.35, 1.0))
def test_a_single_push_is_no_oscillation(push, noise, damping):
    """The joint has the damping of a closed loop: half-waves decay by e^-1.1 or more."""
    joints = Joints()
    times = DT * np.arange(1, 60)
    rate = 40.0 * np.sqrt(max(1 - damping**2, 1e-4))
    response = push * np.exp(-40.0 * damping * times) * np.cos(rate * times)
    amplitudes = [joints.move(noise * (-1) ** k) for k in range(8)]
    amplitudes += [joints.move(x) for x in response]
    assert max(amplitudes) <= max(0.34 * push, noise)


def test_a_slow_motion_is_no_oscillation():
    joints = Joints()
    times = np.arange(0.0, 4.0, DT)
    assert max(joints.move(x) for x in 3.0 * np.sin(2 * np.pi * 1.5 * times)) == 0.0


def test_the_noise_of_differenced_rates_is_no_oscillation():
    """Amplitudes are reduced by the bound of the noise on the rates."""
    encoders = JointSensors(resolution_bits=12, rate="difference", rate_filter_s=0.005)
    bounds = SampleCheck.make(Filter(), Sensors(joint_noise_rad=1e-3, joints=encoders), DT)
    noise = bounds.rate_noise[JOINT_GROUP]
    rates = [2.0, -2.0] * 10
    reduced = Joints(bounds=bounds).move(*rates)
    assert reduced == pytest.approx(Joints().move(*rates) - noise)
    assert Joints(bounds=bounds).move(*[noise, -noise] * 10) == 0
