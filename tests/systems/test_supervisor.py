"""The supervisor as a system: ports, and modes by stepping its inputs."""

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


class Watch:
    """A supervisor in a Simulator; all is well at first."""

    def __init__(self, vehicle):
        self.system = SupervisorSystem(conditions(CONFIG), vehicle, PERIOD, TICK)
        self.simulator = Simulator(self.system)
        self.context = self.simulator.get_mutable_context()
        self.set(
            state=vehicle.trim_state,
            specific_thrust=[9.8],
            status=[0, 0, 0],
            sample_health=np.zeros(6),
            rotor_effectiveness=np.ones(len(vehicle.rotors.names)),
            saturated=[0],
            reference_verdict=[0],
            learner_health=[0, 0],
        )

    def set(self, **ports) -> None:
        for name, value in ports.items():
            self.system.GetInputPort(name).FixValue(self.context, value)

    def after(self, seconds: float) -> tuple[SafeMode, str]:
        """Mode and cause that much later."""
        time = round(self.context.get_time() + seconds, 9)
        self.simulator.AdvanceTo(time)
        mode, cause = (
            int(self.system.GetOutputPort(port).Eval(self.context)[0]) for port in ("mode", "cause")
        )
        return SafeMode(mode), NAMES[cause] if cause >= 0 else ""


@pytest.fixture
def watch(vehicle) -> Watch:
    return Watch(vehicle)


def test_nothing_happens_where_nothing_is_the_matter(watch):
    assert watch.after(10.0) == (SafeMode.NOMINAL, "")
    assert not watch.system.GetOutputPort("conditions").Eval(watch.context).any()


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
        ({"rotor_effectiveness": [1, 1, 0.8, 1]}, SafeMode.NOMINAL, "rotor_degraded"),
    ],
)
def test_what_clears_goes_back_to_nominal(watch, ports, mode, cause):
    was = {name: watch.system.GetInputPort(name).Eval(watch.context).copy() for name in ports}
    watch.set(**ports)
    assert watch.after(1.0) == (mode, cause)
    watch.set(**was)
    assert watch.after(CONFIG.clear_s - PERIOD) == (mode, cause)
    assert watch.after(3 * PERIOD) == (SafeMode.NOMINAL, "")


@pytest.mark.parametrize(
    ("ports", "mode", "cause"),
    [
        ({"status": [5, 0, 250]}, SafeMode.DESCEND, "plan_lost"),
        ({"sample_health": [2.0, 0, 0, 1, 0, 0]}, SafeMode.DESCEND, "position_lost"),
        ({"rotor_effectiveness": [1, 0.3, 1, 1]}, SafeMode.STOP, "rotor_lost"),
        ({"state": None}, SafeMode.STOP, "not_finite"),
    ],
)
def test_what_does_not_clear_is_for_good(watch, vehicle, ports, mode, cause):
    broken = np.full_like(vehicle.trim_state, np.nan)
    watch.set(**{name: broken if value is None else value for name, value in ports.items()})
    assert watch.after(2 * PERIOD) == (mode, cause)
    watch.set(
        state=vehicle.trim_state,
        status=[0, 0, 0],
        sample_health=np.zeros(6),
        rotor_effectiveness=np.ones(4),
    )
    assert watch.after(10.0) == (mode, cause)


def test_a_simulator_ends_where_it_stops(watch):
    watch.after(0.5)
    watch.set(rotor_effectiveness=[1, 0.3, 1, 1])
    status = watch.simulator.AdvanceTo(2.0)
    assert status.reason() == SimulatorStatus.ReturnReason.kReachedTerminationCondition
    assert "rotor_lost" in status.FormatMessage()
    assert watch.context.get_time() == pytest.approx(0.5 + PERIOD)


def test_a_landing_is_over_once_the_ground_carries(watch, vehicle):
    watch.set(status=[5, 0, 250])
    watch.after(0.1)
    landed = vehicle.trim_state
    landed[6] = -vehicle.feet_m
    watch.set(state=landed)
    assert watch.after(1.0) == (SafeMode.DESCEND, "plan_lost")
    watch.set(specific_thrust=[8.0])
    assert watch.after(0.2) == (SafeMode.DESCEND, "plan_lost")
    assert watch.after(0.2) == (SafeMode.STOP, "landed")


def test_who_has_nothing_to_tell_may_be_absent(vehicle):
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


def test_ports_and_rate(watch, vehicle):
    assert not watch.system.HasAnyDirectFeedthrough()
    assert watch.system.GetOutputPort("conditions").size() == len(NAMES)
    timing = watch.system.GetUniquePeriodicDiscreteUpdateAttribute()
    assert (timing.period_sec(), timing.offset_sec()) == (PERIOD, 0)
