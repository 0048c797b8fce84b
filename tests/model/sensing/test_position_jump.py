"""Lasting jumps of the position: size, duration, noise, lost samples, and jumps back."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from aerodrake.model.sensing.estimate import Estimate
from aerodrake.model.sensing.sample import POSITION, Sample
from aerodrake.model.sensing.sample_health import Verdict, split_health
from aerodrake.model.sensing.state_filter import NO_FORCE, FilterState, StateFilter, update
from aerodrake.model.vehicle.state import VehicleState, split_state
from aerodrake.scenario import Filter, Sensors

DT, JOINTS = 0.01, 2
NOISE_M = 0.002
SETTLE_S = 0.5
"""Samples after which the velocity, with which the filter predicts during a jump, is known."""
LIMITS = Filter()
FILTER = StateFilter.make(LIMITS, Sensors(), DT)
unit = arrays(float, 3, elements=st.floats(-1, 1)).map(lambda v: v / max(np.linalg.norm(v), 1e-9))
unit = unit.filter(lambda v: np.linalg.norm(v) > 0.9)


class Flight:
    """A filter that receives the positions of a base that hovers at the origin."""

    def __init__(self, gains: StateFilter = FILTER, noise_m: float = 0.0):
        self.still = np.zeros(VehicleState.size(JOINTS))
        self.still[0] = 1.0
        self.gains, self.noise_m, self.random = gains, noise_m, np.random.default_rng(0)
        self.state, self.time = FilterState.before_samples(gains, self.still, np.zeros(6)), 0.0
        self.observe(np.zeros(3))

    def observe(self, position: np.ndarray) -> Verdict:
        """Returns the verdict on a sample of a position (3,)."""
        state, self.time = self.still.copy(), self.time + DT
        noise = self.noise_m * self.random.standard_normal(3)
        split_state(state).p_B[:] = position + noise
        sample = Sample(state, np.full(3, self.time))
        self.state, self.now = update(
            self.gains, self.state, sample, np.zeros(6), np.zeros(3 * JOINTS), NO_FORCE
        )
        return Verdict(int(split_health(self.state.check.health).verdicts[POSITION]))

    def verdicts(self, position: np.ndarray, duration_s: float) -> list[Verdict]:
        return [self.observe(position) for _ in range(round(duration_s / DT))]

    @property
    def p_B(self) -> np.ndarray:
        return split_state(self.now.state).p_B


@settings(max_examples=15)
@given(along=unit, size=st.floats(0.06, 1.0), noise_m=st.sampled_from([0.0, NOISE_M]))
def test_a_lasting_jump_moves_the_estimate_and_the_offset_alike(along, size, noise_m):
    """A jump back does too: the offset is then the sum of both."""
    flight, bound = Flight(noise_m=noise_m), 10 * noise_m + 1e-9
    flight.verdicts(np.zeros(3), SETTLE_S)
    for position in (size * along, np.zeros(3)):
        verdicts = flight.verdicts(position, LIMITS.reset_after_s + SETTLE_S)
        assert verdicts.count(Verdict.RESET) == 1
        assert set(verdicts[: verdicts.index(Verdict.RESET)]) == {Verdict.JUMP}
        assert set(verdicts[verdicts.index(Verdict.RESET) + 1 :]) == {Verdict.OK}
        np.testing.assert_allclose(flight.p_B, position, atol=bound)
        # Less the motion that was predicted meanwhile.
        np.testing.assert_allclose(flight.state.position_offset, position, atol=4 * bound)


@given(size=st.floats(0.3, 1.0), share=st.floats(0.1, 0.95))
@settings(max_examples=15)
def test_a_short_jump_is_rejected_and_leaves_no_offset(size, share):
    flight = Flight()
    jump = size * np.array([0.0, 0.6, 0.8])
    duration_s = share * LIMITS.reset_after_s
    assert set(flight.verdicts(jump, duration_s if size > 0.5 else 0.4)) == {Verdict.JUMP}
    assert set(flight.verdicts(np.zeros(3), 0.1)) == {Verdict.OK}
    np.testing.assert_allclose(flight.p_B, 0.0, atol=1e-9)
    np.testing.assert_array_equal(flight.state.position_offset, 0.0)


@pytest.mark.parametrize(
    ("positions", "why"),
    [
        (lambda k: [3.0, 0, 0], "larger than reset_m"),
        (lambda k: [(-1.0) ** k, 0, 0], "of changing sides"),
        (lambda k: [1.0 + 0.01 * k, 0, 0], "that moves away at 1 m/s"),
    ],
)
def test_other_jumps_are_rejected(positions, why):
    flight = Flight()
    verdicts = [flight.observe(np.array(positions(k))) for k in range(100)]
    assert set(verdicts) == {Verdict.JUMP}, why


def test_lost_samples_do_not_hide_a_jump():
    """Every other sample is NaN: the others have to last as long."""
    flight, jump = Flight(), np.array([0.0, 0.0, 0.9])
    verdicts = [flight.observe(jump * (np.nan if k % 2 else 1.0)) for k in range(170)]
    reset = verdicts.index(Verdict.RESET)
    assert verdicts[:reset].count(Verdict.JUMP) == pytest.approx(80, abs=1)
    assert set(verdicts[reset + 1 :]) == {Verdict.OK, Verdict.NOT_FINITE}


def test_a_wrong_velocity_is_never_a_reset():
    flight = Flight()
    split_state(flight.still).v_B[:] = [20.0, 0.0, 0.0]
    verdicts = [flight.observe(np.array([0.9, 0, 1e-6 * k])) for k in range(100)]
    assert set(verdicts) == {Verdict.JUMP}


def test_the_first_sample_replaces_the_estimate_wherever_it_is():
    """Late ones as well: with an offset by which setpoints move."""
    for lost in (0, 30):
        state = FilterState.before_samples(FILTER, Flight().still, np.zeros(6))
        at = Flight().still.copy()
        split_state(at).p_B[:] = [5.0, -3.0, 1.0]
        split_state(at).v_B[:] = [1.0, 0.0, 0.0]
        for k in range(lost + 1):
            sample = np.full_like(at, np.nan) if k < lost else at
            stamped = Sample(sample, np.full(3, DT * k))
            state, now = update(FILTER, state, stamped, np.zeros(6), np.zeros(3 * JOINTS), NO_FORCE)
        assert isinstance(now, Estimate)
        np.testing.assert_array_equal(now.state, at)
        expected = [5.0, -3.0, 1.0] if lost else np.zeros(3)
        np.testing.assert_array_equal(state.position_offset, expected)
        verdict = split_health(state.check.health).verdicts[POSITION]
        assert verdict == (Verdict.RESET if lost else Verdict.OK)
