"""Tests of the supervisor as a system: ports, rate, and modes for given inputs."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator, SimulatorStatus

from aerodrake.model.supervision.conditions import conditions
from aerodrake.model.supervision.safe_mode import SafeMode
from aerodrake.scenario import Supervisor as Config
from aerodrake.systems.supervisor import SupervisorSystem

PERIOD, TICK = 0.01, 0.02
CONFIG = Config()
NAMES = [condition.name for condition in conditions(CONFIG)]


class SupervisedFlight:
    """A supervisor in a Simulator; its inputs are healthy at first."""

    def __init__(self, vehicle):
        self.system = SupervisorSystem(conditions(CONFIG), vehicle, PERIOD, TICK)
        self.simulator = Simulator(self.system)
        self.context = self.simulator.get_mutable_context()
        self.set(
            state=vehicle.trim_state,
            specific_thrust=[9.8],
            status=[0, 0, 0],
            sample_health=np.zeros(6),
            joint_oscillation=np.zeros(6),
            torque_at_limit=np.zeros(6),
            rotor_effectiveness=np.ones(len(vehicle.rotors.names)),
            saturated=[0],
            reference_verdict=[0],
            learner_health=[0, 0],
        )

    def set(self, **ports) -> None:
        for name, value in ports.items():
            self.system.GetInputPort(name).FixValue(self.context, value)

    def after(self, seconds: float) -> tuple[SafeMode, str]:
        """Returns mode and cause after some time."""
        time = round(self.context.get_time() + seconds, 9)
        self.simulator.AdvanceTo(time)
        mode, cause = (
            int(self.system.GetOutputPort(port).Eval(self.context)[0]) for port in ("mode", "cause")
        )
        return SafeMode(mode), NAMES[cause] if cause >= 0 else ""


@pytest.fixture
def flight(vehicle) -> SupervisedFlight:
    return SupervisedFlight(vehicle)


def test_nominal_while_all_inputs_are_healthy(flight):
    assert flight.after(10.0) == (SafeMode.NOMINAL, "")
    assert not flight.system.GetOutputPort("conditions").Eval(flight.context).any()


@pytest.mark.parametrize(
    ("ports", "mode", "cause"),
    [
        ({"status": [6, 200, 5]}, SafeMode.HOLD, "plan_outage"),
        ({"sample_health": [0.3, 0, 0, 1, 0, 0]}, SafeMode.HOLD, "position_outage"),
        ({"reference_verdict": [1]}, SafeMode.HOLD, "reference_not_finite"),
        ({"reference_verdict": [2]}, SafeMode.HOLD, "reference_out_of_reach"),
        ({"reference_verdict": [3]}, SafeMode.HOLD, "reference_too_fast"),
        ({"reference_verdict": [4]}, SafeMode.NOMINAL, "reference_jump"),
        ({"learner_health": [2, 0.02]}, SafeMode.NOMINAL, "learner_shut_out"),
        ({"saturated": [1]}, SafeMode.NOMINAL, "saturated"),
        ({"joint_oscillation": [0, 0, 0, 0.5, 0, 0]}, SafeMode.HOLD, "joint_oscillation"),
        ({"torque_at_limit": [0, 1, 0, 0, 0, 0]}, SafeMode.NOMINAL, "torque_at_limit"),
        ({"rotor_effectiveness": [1, 1, 0.8, 1]}, SafeMode.NOMINAL, "rotor_degraded"),
    ],
)
def test_returns_to_nominal_once_a_condition_clears(flight, ports, mode, cause):
    healthy = {name: flight.system.GetInputPort(name).Eval(flight.context).copy() for name in ports}
    flight.set(**ports)
    assert flight.after(1.0) == (mode, cause)
    flight.set(**healthy)
    assert flight.after(CONFIG.clear_s - PERIOD) == (mode, cause)
    assert flight.after(3 * PERIOD) == (SafeMode.NOMINAL, "")


@pytest.mark.parametrize(
    ("ports", "mode", "cause"),
    [
        ({"status": [5, 0, 250]}, SafeMode.DESCEND, "plan_lost"),
        ({"sample_health": [2.0, 0, 0, 1, 0, 0]}, SafeMode.DESCEND, "position_lost"),
        ({"rotor_effectiveness": [1, 0.3, 1, 1]}, SafeMode.STOP, "rotor_lost"),
        ({"state": None}, SafeMode.STOP, "not_finite"),
    ],
)
def test_permanent_conditions_do_not_clear(flight, vehicle, ports, mode, cause):
    broken = np.full_like(vehicle.trim_state, np.nan)
    flight.set(**{name: broken if value is None else value for name, value in ports.items()})
    assert flight.after(2 * PERIOD) == (mode, cause)
    flight.set(
        state=vehicle.trim_state,
        status=[0, 0, 0],
        sample_health=np.zeros(6),
        rotor_effectiveness=np.ones(4),
    )
    assert flight.after(10.0) == (mode, cause)


def test_stop_terminates_the_simulator(flight):
    flight.after(0.5)
    flight.set(rotor_effectiveness=[1, 0.3, 1, 1])
    status = flight.simulator.AdvanceTo(2.0)
    assert status.reason() == SimulatorStatus.ReturnReason.kReachedTerminationCondition
    assert "rotor_lost" in status.FormatMessage()
    assert flight.context.get_time() == pytest.approx(0.5 + PERIOD)


def test_landed_once_the_ground_carries_weight(flight, vehicle):
    flight.set(status=[5, 0, 250])
    flight.after(0.1)
    landed = vehicle.trim_state
    landed[6] = -vehicle.feet_m
    flight.set(state=landed)
    assert flight.after(1.0) == (SafeMode.DESCEND, "plan_lost")
    flight.set(specific_thrust=[8.0])
    assert flight.after(0.2) == (SafeMode.DESCEND, "plan_lost")
    assert flight.after(0.2) == (SafeMode.STOP, "landed")


def test_unconnected_health_ports_mean_healthy(vehicle):
    system = SupervisorSystem(conditions(CONFIG), vehicle, PERIOD, TICK)
    simulator = Simulator(system)
    context = simulator.get_mutable_context()
    for port, value in (
        ("state", vehicle.trim_state),
        ("specific_thrust", [9.8]),
        ("status", [0, 0, 0]),
        ("saturated", [0]),
        ("reference_verdict", [0]),
    ):
        system.GetInputPort(port).FixValue(context, value)
    simulator.AdvanceTo(1.0)
    assert not system.GetOutputPort("conditions").Eval(context).any()


def test_ports_and_rate(flight, vehicle):
    assert not flight.system.HasAnyDirectFeedthrough()
    assert flight.system.GetOutputPort("conditions").size() == len(NAMES)
    timing = flight.system.GetUniquePeriodicDiscreteUpdateAttribute()
    assert (timing.period_sec(), timing.offset_sec()) == (PERIOD, 0)
