"""The weight allocator in time: memory of its mode, hysteresis, and feedthrough."""

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

    def look(self, d_e: float, d_o: float, d_g: float) -> np.ndarray:
        """(5,) the output, without a tick."""
        self.allocator.GetInputPort("distances").FixValue(self.context, [d_e, d_o])
        self.allocator.GetInputPort("d_g").FixValue(self.context, [d_g])
        return self.allocator.GetOutputPort("weights").Eval(self.context)

    def tick(self, d_e: float, d_o: float, d_g: float) -> Mode:
        """The mode at a tick, as the MPC pulls it."""
        mode = Mode(int(self.look(d_e, d_o, d_g)[1]))
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
    for value, expected in zip(driver.look(*distances), weights, strict=True):
        assert expected is None or value == pytest.approx(expected, rel=1e-12)


def test_feeds_through_from_both_inputs(allocator, driver):
    assert allocator.HasDirectFeedthrough(0, 0) and allocator.HasDirectFeedthrough(1, 0)
    # And in fact: each input changes the output at once, without a tick.
    seen = [driver.look(*d)[1] for d in ((0.01, 0.0, 0.0), (2.0, 0.0, 0.0), (0.5, 0.0, LARGE))]
    assert seen == [HOVER, FLIGHT, COORDINATED]


def test_modes_over_time(driver):
    """Out past a boundary by more than 10 % to leave a mode, back inside it to return."""
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


def test_chatter_within_the_band_changes_nothing(driver):
    for start, mode in ((0.05, HOVER), (0.09, FLIGHT)):
        driver.tick(start, 0.0, 0.0)
        noise = np.random.default_rng(0).uniform(0.0751, 0.0824, 100)
        assert {driver.tick(d_e, 0.0, 0.0) for d_e in noise} == {mode}


def test_only_ticks_are_remembered(driver):
    """What is seen between ticks leaves no trace in the hysteresis."""
    assert driver.tick(0.50, 0.0, LARGE) is COORDINATED
    assert driver.look(1.50, 0.0, LARGE)[1] == FLIGHT
    assert driver.look(1.05, 0.0, LARGE)[1] == COORDINATED
    assert driver.tick(1.50, 0.0, LARGE) is FLIGHT
    assert driver.look(1.05, 0.0, LARGE)[1] == FLIGHT


def test_the_output_follows_the_memory(allocator, driver):
    """Also when the inputs have not changed: what is cached is not stale."""
    assert driver.look(1.05, 0.0, LARGE)[1] == COORDINATED
    driver.context.SetDiscreteState([FLIGHT])
    assert allocator.GetOutputPort("weights").Eval(driver.context)[1] == FLIGHT


def test_starts_in_hover_and_ticks_at_its_period(allocator, driver):
    assert driver.look(0.08, 0.08, 0.0)[1] == HOVER  # Within both bands.
    timing = allocator.GetUniquePeriodicDiscreteUpdateAttribute()
    assert (timing.period_sec(), timing.offset_sec()) == (0.02, 0)
