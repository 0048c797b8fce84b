"""Flights from a state of the plant that the user sets in its Context, as usual in Drake."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.math import RollPitchYaw
from pydrake.systems.analysis import Simulator

from aerodrake.model.vehicle.state import split_state
from aerodrake.scenario import SampleFrozen, SampleNan, SampleStale
from aerodrake.scenario.load import load_scenario
from aerodrake.station import make_closed_loop, make_context
from tests.robots import multibody_plant

SETTLE_S = 3.5


class Flight:
    """A closed loop with a state that is set before the Simulator starts."""

    def __init__(self, name: str, *faults, yaw=0.0, dp=(0, 0, 0), v=(0, 0, 0), joints=0.0):
        scenario = replace(load_scenario(name), faults=faults, settle_s=SETTLE_S)
        self.loop = make_closed_loop(scenario)
        self.context = make_context(self.loop, 0)
        plant = multibody_plant(self.loop)
        own = plant.GetMyMutableContextFromRoot(self.context)
        q = plant.GetPositions(own).copy()
        self.start = self.true_p_B
        q[:4] = RollPitchYaw(0, 0, yaw).ToQuaternion().wxyz()
        q[4:7] += dp
        q[7:] += joints
        plant.SetPositions(own, q)
        plant.SetVelocities(own, np.concatenate([np.zeros(3), v, np.zeros(len(q) - 7)]))
        self.simulator = Simulator(self.loop, self.context)

    def output(self, name: str) -> np.ndarray:
        return self.loop.GetOutputPort(name).Eval(self.context).copy()

    @property
    def true_p_B(self) -> np.ndarray:
        return split_state(self.output("true_state")).p_B

    def advance(self, time: float) -> None:
        self.simulator.AdvanceTo(time)


def flight_errors(flight: Flight) -> tuple[float, float]:
    """Returns the base's distances in m from trim and of the estimate, at the end of the hover."""
    modes = []
    for time in np.arange(0.1, SETTLE_S + 0.05, 0.1):
        flight.advance(time)
        modes.append(flight.output("mode")[0])
    assert not any(modes), "HOLD or worse"
    estimate = split_state(flight.output("state")).p_B
    away = np.linalg.norm(flight.true_p_B - flight.start)
    return away, np.linalg.norm(estimate - flight.true_p_B)


@pytest.mark.parametrize(
    "start",
    [
        {"dp": (0.1, 0, 0)},
        {"dp": (0.3, -0.3, 0.2), "yaw": 1.0, "joints": 0.2},
        {"v": (0.8, 0.3, -0.2)},
    ],
)
def test_exact_sensors_fly_to_the_reference(start):
    away, error = flight_errors(Flight("clover", **start))
    assert away < 0.1 and error < 1e-4


@pytest.mark.parametrize("fault", [SampleNan, SampleStale, SampleFrozen])
def test_delay_noise_and_faults_at_time_0(fault):
    """From base + 0.5 m and in motion, with faults of the first 0.2 s."""
    flight = Flight(
        "clover_realistic",
        fault(group="position", start_s=-SETTLE_S, duration_s=0.2),
        dp=(0.0, 0.5, 0.0),
        v=(0.0, -0.3, 0.2),
    )
    away, error = flight_errors(flight)
    assert away < 0.15 and error < 0.02


def test_a_clone_continues_bit_for_bit():
    """A Simulator of its own may initialise it again."""
    flight = Flight("clover_realistic", dp=(0.2, 0, 0), v=(0.1, 0, 0))
    flight.advance(0.035)
    clone = flight.context.Clone()
    flight.advance(0.3)
    Simulator(flight.loop, clone).AdvanceTo(0.3)
    state = flight.context.get_discrete_state()
    for i in range(state.num_groups()):
        np.testing.assert_array_equal(state.value(i), clone.get_discrete_state().value(i))
