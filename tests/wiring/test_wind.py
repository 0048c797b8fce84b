"""Wind without a plant: statistics of its gusts, and repeatability by seed."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource, LogVectorOutput

from aerodrake.scenario import Wind
from aerodrake.station import make_context
from aerodrake.wiring.wind import make_wind

JOINTS, PERIOD = 6, 0.01
MEAN, SIGMA, T = np.array([2.0, 0.0, -1.0]), np.array([1.0, 0.5, 0.0]), 0.1


class Air:
    """Wind on a base at rest with a force in N equal to its velocity in m/s."""

    def __init__(self, vehicle):
        config = Wind(
            velocity_m_s=tuple(MEAN),
            gust_m_s=tuple(SIGMA),
            gust_correlation_s=T,
            quadratic_drag_n_s2_m2=0.0,
            linear_drag_n_s_m=1.0,
        )
        builder = DiagramBuilder()
        self.wind = builder.AddSystem(make_wind(config, JOINTS, PERIOD))
        base = builder.AddSystem(ConstantVectorSource(vehicle.trim_state))
        builder.Connect(base.get_output_port(), self.wind.get_input_port())
        self._log = LogVectorOutput(self.wind.GetOutputPort("wind_force"), builder, PERIOD)
        self.diagram = builder.Build()

    def samples(self, context) -> np.ndarray:
        """Returns logged samples (samples, 3) m/s; the first force is of the event at time 0."""
        return self._log.FindLog(context).data().T[1:]

    def blow(self, duration: float, seed: int = 0) -> np.ndarray:
        context = make_context(self.diagram, seed)
        Simulator(self.diagram, context).AdvanceTo(duration)
        return self.samples(context)

    def first(self, seed: int) -> np.ndarray:
        """Returns the velocity (3,) m/s at time 0."""
        context = make_context(self.diagram, seed)
        air = self.wind.GetSubsystemByName("air")
        return air.get_output_port().Eval(air.GetMyContextFromRoot(context))


@pytest.fixture(scope="module")
def air(vehicle):
    return Air(vehicle)


@pytest.fixture(scope="module")
def gusts(air):
    """Returns gusts over sigma (samples, 2) of 3000 correlation times, for the axes with gusts."""
    velocity = air.blow(3000 * T)
    np.testing.assert_array_equal(velocity[:, 2], MEAN[2])  # The third axis has no gusts.
    return (velocity[:, :2] - MEAN[:2]) / SIGMA[:2]


def test_mean_and_deviation(gusts):
    """To four standard errors of 3000 correlation times: sqrt(2 / 3000) and sqrt(1 / 3000)."""
    np.testing.assert_allclose(gusts.mean(axis=0), 0, atol=0.10)
    np.testing.assert_allclose((gusts**2).mean(axis=0), 1, atol=0.08)


@pytest.mark.parametrize("lag", [1, 5, 10, 20, 60])
def test_correlation_decays_exponentially(gusts, lag):
    correlation = (gusts[lag:] * gusts[:-lag]).mean(axis=0) / (gusts**2).mean(axis=0)
    np.testing.assert_allclose(correlation, np.exp(-lag * PERIOD / T), atol=0.08)


def test_its_increments_are_white_and_independent_by_axis(gusts):
    a = np.exp(-PERIOD / T)
    steps = (gusts[1:] - a * gusts[:-1]) / np.sqrt(1 - a * a)
    both = np.hstack([steps[1:], steps[:-1]])
    np.testing.assert_allclose(np.cov(both.T), np.eye(4), atol=0.04)


def test_it_is_stationary_from_the_start(air):
    """Over many seeds, gusts at time 0 have the stationary distribution."""
    first = np.array([air.first(seed) for seed in range(1000)])
    assert first.mean(axis=0) == pytest.approx(MEAN, abs=0.13)
    assert first.std(axis=0) == pytest.approx(SIGMA, abs=0.09)


def test_gusts_depend_on_the_seed_alone(air, vehicle):
    first = air.blow(1.0, seed=3)
    np.testing.assert_array_equal(first, air.blow(1.0, seed=3))
    np.testing.assert_array_equal(first, Air(vehicle).blow(1.0, seed=3))
    other = air.blow(1.0, seed=4)
    assert np.all(first[:, :2] != other[:, :2])


def test_a_cloned_context_continues_identically(air):
    context = make_context(air.diagram, 5)
    Simulator(air.diagram, context).AdvanceTo(0.505)
    clone = context.Clone()
    for each in (context, clone):
        Simulator(air.diagram, each).AdvanceTo(1.0)
        np.testing.assert_array_equal(air.samples(each), air.blow(1.0, seed=5))


def test_still_air_exerts_no_force_on_a_moving_base(vehicle):
    wind = make_wind(Wind(), JOINTS, PERIOD)
    context = make_context(wind, 0)
    state = vehicle.trim_state
    state[16:19] = 3.0, 2.0, 1.0
    wind.get_input_port().FixValue(context, state)
    Simulator(wind, context).AdvanceTo(1.0)
    np.testing.assert_array_equal(wind.GetOutputPort("wind_force").Eval(context), 0)
    np.testing.assert_array_equal(wind.GetOutputPort("generalized_force").Eval(context), 0)


def test_wind_that_varies_in_space_is_that_at_the_base(vehicle):
    """The base is at p = (0, 0, 1.5) m, where the wave is zero, and then a quarter wave ahead."""
    config = Wind(
        velocity_m_s=(1.0, 0.0, 0.0),
        shear_exponent=1.0,
        reference_height_m=3.0,
        wave_m_s=(0.0, 2.0, 0.0),
        wave_rad_m=(np.pi / 2, 0.0, 0.0),
        quadratic_drag_n_s2_m2=0.0,
        linear_drag_n_s_m=0.5,
    )
    wind = make_wind(config, JOINTS, PERIOD)
    simulator = Simulator(wind)
    context, x = simulator.get_mutable_context(), vehicle.trim_state.copy()
    for ahead, wave in ((0.0, 0.0), (1.0, 2.0)):
        x[4] = ahead
        wind.get_input_port().FixValue(context, x)
        velocity = wind.GetOutputPort("wind_velocity").Eval(context)
        np.testing.assert_allclose(velocity, [0.5, wave, 0.0], atol=1e-12)
        simulator.AdvanceTo(context.get_time() + PERIOD)
        force = wind.GetOutputPort("wind_force").Eval(context)
        np.testing.assert_allclose(force, 0.5 * velocity, atol=1e-12)
