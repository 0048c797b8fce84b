"""Rates, offsets and latencies of the closed loop, measured by its events."""

from collections import defaultdict
from dataclasses import replace

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from aerodrake.scenario import Filter, MovingTarget, Rates, Sensors, Wind
from aerodrake.station import RATES, leaf_systems, make_closed_loop, make_context
from aerodrake.systems.arm_controller import ArmController
from aerodrake.systems.flight_controller import FlightController
from aerodrake.systems.mpc import MpcSystem
from aerodrake.systems.residual_estimator import ResidualEstimator
from aerodrake.systems.sensors import SensorSystem
from aerodrake.systems.setpoint_integrator import SetpointIntegrator
from aerodrake.systems.weight_allocator import WeightAllocator
from aerodrake.systems.wind_force import WindForce
from aerodrake.wiring.table import Rate
from tests.robots import multibody_plant

UPDATES = {
    FlightController: "_update",
    ArmController: "_update",
    MpcSystem: "_update",
    ResidualEstimator: "_update",
    WeightAllocator: "_update",
    SetpointIntegrator: "_update",
    SensorSystem: "_sample",
    WindForce: "_update",
}
SEES = {
    FlightController: ("state", "base_setpoint"),
    ArmController: ("state", "joint_setpoint"),
    MpcSystem: ("state",),
    SensorSystem: ("true_state",),
    WindForce: ("true_state",),
}
"""Input ports that are recorded at each event."""

BREEZE = Wind(velocity_m_s=(0.5, 0.0, 0.0), gust_m_s=(0.1, 0.1, 0.1))


class Recorder:
    """Closed loop that records its events."""

    def __init__(self, scenario):
        self.times = defaultdict(list)
        self.seen = defaultdict(list)
        with pytest.MonkeyPatch.context() as patch:
            for kind, method in UPDATES.items():
                patch.setattr(kind, method, self._recorded(kind, getattr(kind, method)))
            self.diagram = make_closed_loop(scenario)
            self.context = make_context(self.diagram, scenario.seed)
            self.simulator = Simulator(self.diagram, self.context)

    def _recorded(self, kind, update):
        def record(system, context, state):
            self.times[kind].append(context.get_time())
            for port in SEES.get(kind, ()):
                value = system.GetInputPort(port).Eval(context).copy()
                self.seen[kind, port].append(value)
            return update(system, context, state)

        return record

    def output(self, port: str) -> np.ndarray:
        return self.diagram.GetOutputPort(port).Eval(self.context).copy()


def make_moving(scenario) -> Recorder:
    """Returns a closed loop in motion, so that all samples differ."""
    recorder = Recorder(scenario)
    plant = multibody_plant(recorder.diagram)
    velocities = np.zeros(plant.num_velocities())
    velocities[3:6] = 0.2, -0.1, 0.1
    plant.SetVelocities(plant.GetMyMutableContextFromRoot(recorder.context), velocities)
    return recorder


@pytest.fixture(scope="module")
def second(scenario) -> Recorder:
    """Returns one recorded second in a breeze, shared by all tests."""
    recorder = make_moving(replace(scenario, wind=BREEZE))
    recorder.instants = []
    recorder.simulator.set_monitor(lambda context: recorder.instants.append(context.get_time()))
    recorder.simulator.AdvanceTo(1.0)
    return recorder


NAMES = {
    FlightController: "flight_controller",
    ArmController: "arm_controller",
    MpcSystem: "mpc",
    ResidualEstimator: "residual_estimator",
    WeightAllocator: "weight_allocator",
    SetpointIntegrator: "setpoint_integrator",
    SensorSystem: "sampler",
    WindForce: "wind_force",
}


def rate_of(name: str) -> Rate:
    """Returns the row of the table of rates that lists a system."""
    (rate,) = (rate for rate in RATES if name in rate.systems)
    return rate


def timing(rate: Rate, rates: Rates) -> tuple[float, float]:
    """Returns the period and the time of the first event in s."""
    period, offset = getattr(rates, rate.period), rate.offset_steps * rates.plant_step_s
    return period, offset % period


@pytest.mark.parametrize("kind", NAMES)
def test_events_of_a_second(second, scenario, kind):
    """The first event is at its offset; the event at t = 1 s is not included."""
    period, offset = timing(rate_of(NAMES[kind]), scenario.rates)
    expected = offset + period * np.arange(round(1 / period))
    np.testing.assert_allclose(second.times[kind], expected, atol=1e-9)


@pytest.mark.parametrize(
    "rates", [Rates(), Rates(0.0005, 0.004, 0.008, 0.002, 0.016)], ids=["default", "other"]
)
@pytest.mark.parametrize("controller", ["mpc", "clik"])
def test_table_of_rates(scenario, rates, controller):
    """Every periodic update of the closed loop is in the table, with period and offset."""
    changed = {"sensors": Sensors(base_delay_s=0.02), "filter": Filter(delay_s=0.02)}
    flown = replace(scenario, rates=rates, controller=controller, wind=BREEZE, **changed)
    closed_loop = make_closed_loop(flown)
    systems = {system.get_name(): system for system in leaf_systems(closed_loop)}
    systems["plant"] = systems.pop("multibody_plant")  # The one with updates in the plant.
    listed = {name for rate in RATES for name in rate.systems}
    assert listed - systems.keys() == {"mpc", "clik"} - {controller}
    for name, system in systems.items():
        attribute = system.GetUniquePeriodicDiscreteUpdateAttribute()
        if attribute is None:
            assert name not in listed or rate_of(name).kind == "unrestricted"
            continue
        assert rate_of(name).kind == "discrete"
        measured = attribute.period_sec(), attribute.offset_sec()
        assert measured == pytest.approx(timing(rate_of(name), rates), abs=1e-12), name


def test_plant_and_rotors_step_every_millisecond(scenario):
    """Sampled every quarter of a millisecond, in motion."""
    moving, seen = make_moving(scenario), defaultdict(list)
    for time in 0.05 + 1e-5 + 0.00025 * np.arange(80):
        moving.simulator.AdvanceTo(time)
        for port in ("true_state", "thrust"):
            seen[port].append(moving.output(port))
    for port, rows in seen.items():
        changed = np.any(np.diff(rows, axis=0) != 0, axis=1)
        np.testing.assert_array_equal(changed, np.arange(1, 80) % 4 == 0, err_msg=port)


def test_events_of_one_instant_are_at_the_very_same_time(second):
    """Otherwise rounding would decide their order, and with it the latency."""
    assert np.diff(np.unique(second.instants)).min() > 1e-6


def test_only_the_noise_comes_before_the_discrete_updates(second):
    """There is one unrestricted update per sample, and one for the first sample before time 0."""
    assert second.simulator.get_num_unrestricted_updates() == 100 + 1


def test_the_wind_samples_the_base_at_its_instant(second):
    """The sensors sample the same state a quarter of a step before."""
    seen, sampled = (second.seen[kind, "true_state"] for kind in (WindForce, SensorSystem))
    assert len(np.unique(seen, axis=0)) == 100
    np.testing.assert_array_equal(seen[1:], sampled[:-1])


def test_steps_of_the_plant_call_no_python_for_the_wind(scenario, monkeypatch):
    """The applied force is evaluated once per sample, and once at the start."""
    told = []
    calc = WindForce._calc_generalized_force

    def count(system, context, output):
        told.append(context.get_time())
        return calc(system, context, output)

    monkeypatch.setattr(WindForce, "_calc_generalized_force", count)
    for wind, times in ((BREEZE, [0.0, *(0.001 + 0.01 * np.arange(10))]), (Wind(), [0.0])):
        told.clear()
        recorder = make_moving(replace(scenario, wind=wind))
        recorder.simulator.AdvanceTo(0.0995)
        np.testing.assert_allclose(told, times, atol=1e-9)
        assert len(recorder.times[WindForce]) == len(times) - 1


def test_controllers_and_mpc_act_on_the_same_sample(second):
    sampled = second.seen[MpcSystem, "state"]
    assert len(np.unique(sampled, axis=0)) == len(sampled) == 50
    for kind, events in ((FlightController, 2), (ArmController, 4)):
        seen = second.seen[kind, "state"]
        np.testing.assert_array_equal(seen[::events], sampled, err_msg=kind.__name__)
    # The second of two torques between samples is of the same sample.
    np.testing.assert_array_equal(second.seen[ArmController, "state"][1::4], sampled)


def test_controllers_act_on_the_newest_sample_even_if_one_is_taken_at_every_step(scenario):
    rates = Rates(*[0.005] * 4, mpc_period_s=0.020)
    recorder = make_moving(replace(scenario, rates=rates))
    recorder.simulator.AdvanceTo(0.2)
    sampled = recorder.seen[SensorSystem, "true_state"]
    assert len(np.unique(sampled, axis=0)) == len(sampled) == 40
    for kind in (FlightController, ArmController):
        np.testing.assert_array_equal(recorder.seen[kind, "state"][1:], sampled[:-1])


def test_commands_of_the_mpc_reach_the_controllers_half_a_step_later(scenario):
    """Not a tick later: a_d and q_d'' are the u of this sample."""
    far = MovingTarget(target_m=(0.3, 0.6, 0.0))
    recorder = Recorder(replace(scenario, settle_s=0.0, reference=far))
    last = np.zeros(9)
    recorder.simulator.AdvanceTo(1e-6)
    for k in range(1, 11):
        recorder.simulator.AdvanceTo(0.02 * k + 1e-6)
        u = recorder.output("u")
        recorder.simulator.AdvanceTo(0.02 * k + 0.0008)
        a_d = recorder.seen[FlightController, "base_setpoint"][-1][6:]
        qddot_d = recorder.seen[ArmController, "joint_setpoint"][-1][-6:]
        assert recorder.times[FlightController][-1] == pytest.approx(0.02 * k + 0.0005)
        assert np.all(u != last)
        np.testing.assert_array_equal(a_d, u[:3])
        np.testing.assert_array_equal(qddot_d, u[3:])
        last = u


def test_from_a_change_of_the_state_to_thrust_and_torque_in_half_a_step(scenario):
    recorder = Recorder(scenario)
    plant = multibody_plant(recorder.diagram)
    t = 0.1
    recorder.simulator.AdvanceTo(t - 0.0005)  # Between two steps of the plant.
    trim = {port: recorder.output(port) for port in ("state", "thrust_command", "joint_torque")}

    plant_context = plant.GetMyMutableContextFromRoot(recorder.context)
    q = plant.GetPositions(plant_context)
    q[6] -= 0.01  # z of the base.
    q[-1] += 0.01  # The last joint.
    plant.SetPositions(plant_context, q)

    def changed() -> list[str]:
        return [port for port in trim if np.any(np.abs(recorder.output(port) - trim[port]) > 1e-4)]

    assert changed() == []
    recorder.simulator.AdvanceTo(t)
    assert changed() == []  # The filter's update is due now.
    for time in (t + 1e-6, t + 0.0004):
        recorder.simulator.AdvanceTo(time)
        assert changed() == ["state"]
    recorder.simulator.AdvanceTo(t + 0.0006)
    assert changed() == ["state", "thrust_command", "joint_torque"]
    assert np.sum(recorder.output("thrust_command")) > np.sum(trim["thrust_command"])
    assert recorder.output("joint_torque")[-1] < trim["joint_torque"][-1]
