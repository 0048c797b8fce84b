"""WeightAllocator over time: state, hysteresis, and direct feedthrough."""

import math

import numpy as np
import pytest

from aerodrake.model.mpc.weight_allocation import Mode
from aerodrake.scenario import Allocation
from aerodrake.systems.weight_allocator import WeightAllocator

FLIGHT, COORDINATED, HOVER, ADJUSTMENT = Mode
CONFIG = Allocation()  # d_h 0.075 m, d_f 1 m; k_q 1000, k_m 10, k_d 100.
LARGE = math.inf


@pytest.fixture
def allocator() -> WeightAllocator:
    return WeightAllocator(CONFIG, 0.02)


class Driver:
    def __init__(self, allocator):
        self.allocator, self.context = allocator, allocator.CreateDefaultContext()

    def weights(self, d_e: float, d_o: float, d_g: float) -> np.ndarray:
        """Returns the output (5,) without a tick."""
        self.allocator.GetInputPort("distances").FixValue(self.context, [d_e, d_o])
        self.allocator.GetInputPort("d_g").FixValue(self.context, [d_g])
        return self.allocator.GetOutputPort("weights").Eval(self.context)

    def tick(self, d_e: float, d_o: float, d_g: float) -> Mode:
        """Updates the state; returns the mode that the MPC samples at that tick."""
        mode = Mode(int(self.weights(d_e, d_o, d_g)[1]))
        self.context.SetDiscreteState(self.allocator.EvalUniquePeriodicDiscreteUpdate(self.context))
        return mode


@pytest.fixture
def driver(allocator) -> Driver:
    return Driver(allocator)


@pytest.mark.parametrize(
    ("distances", "weights"),
    [
        ((1.50, 0.05, LARGE), (0.0, FLIGHT, 100, 1000, 5 / 1.1)),
        ((0.01, 0.05, 0.00), (1.0, HOVER, 1100, 10 / 1.01, 5 / 2.1)),
        ((0.505, 0.02, LARGE), (1.075 / 1.505, COORDINATED, None, None, None)),
        # Half way from d_h to d_edge.
        ((0.01, 0.2275, 0.00), (-0.5, ADJUSTMENT, 350, 10 / 0.51, 22.75 / 0.6)),
    ],
)
def test_weights_by_hand(driver, distances, weights):
    for value, expected in zip(driver.weights(*distances), weights, strict=True):
        assert expected is None or value == pytest.approx(expected, rel=1e-12)


def test_both_inputs_have_direct_feedthrough(allocator, driver):
    assert allocator.HasDirectFeedthrough(0, 0) and allocator.HasDirectFeedthrough(1, 0)
    # Each input changes the output without a tick.
    modes = [driver.weights(*d)[1] for d in ((0.01, 0.0, 0.0), (2.0, 0.0, 0.0), (0.5, 0.0, LARGE))]
    assert modes == [HOVER, FLIGHT, COORDINATED]


def test_modes_over_time(driver):
    """A mode is left 10 % beyond its boundary and entered within it."""
    flight = [
        (0.50, 0.00, COORDINATED),
        (0.99, 0.00, COORDINATED),
        (1.09, 0.00, COORDINATED),
        (1.11, 0.00, FLIGHT),
        (1.01, 0.00, FLIGHT),
        (1.09, 0.00, FLIGHT),
        (0.99, 0.00, COORDINATED),
        (1.09, 0.00, COORDINATED),
        (0.10, 0.08, COORDINATED),
        (0.10, 0.083, ADJUSTMENT),
        (0.10, 0.076, ADJUSTMENT),
        (0.10, 0.074, COORDINATED),
        (0.10, 0.082, COORDINATED),
    ]
    modes = [driver.tick(d_e, d_o, LARGE) for d_e, d_o, _ in flight]
    assert modes == [mode for _, _, mode in flight]


def test_noise_within_the_hysteresis_band_does_not_change_the_mode(driver):
    for start, mode in ((0.05, HOVER), (0.09, FLIGHT)):
        driver.tick(start, 0.0, 0.0)
        noise = np.random.default_rng(0).uniform(0.0751, 0.0824, 100)
        assert {driver.tick(d_e, 0.0, 0.0) for d_e in noise} == {mode}


def test_only_ticks_change_the_state(driver):
    """Outputs between ticks do not affect the hysteresis."""
    assert driver.tick(0.50, 0.0, LARGE) is COORDINATED
    assert driver.weights(1.50, 0.0, LARGE)[1] == FLIGHT
    assert driver.weights(1.05, 0.0, LARGE)[1] == COORDINATED
    assert driver.tick(1.50, 0.0, LARGE) is FLIGHT
    assert driver.weights(1.05, 0.0, LARGE)[1] == FLIGHT


def test_the_output_depends_on_the_state(allocator, driver):
    """The cached output is invalidated even if the inputs do not change."""
    assert driver.weights(1.05, 0.0, LARGE)[1] == COORDINATED
    driver.context.SetDiscreteState([FLIGHT])
    assert allocator.GetOutputPort("weights").Eval(driver.context)[1] == FLIGHT


def test_starts_in_hover_and_ticks_at_its_period(allocator, driver):
    assert driver.weights(0.08, 0.08, 0.0)[1] == HOVER  # Within both bands.
    timing = allocator.GetUniquePeriodicDiscreteUpdateAttribute()
    assert (timing.period_sec(), timing.offset_sec()) == (0.02, 0)
