"""ClikSystem: ports and status; flown in place of the MPC."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.common.value import Value

from aerodrake.flight.simulate import FlightSimulation
from aerodrake.model.equivalent.initial_state import Signals
from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.model.mpc.clik import InverseKinematics
from aerodrake.model.mpc.formulation import MpcFormulation
from aerodrake.model.qp.result import QpStatus
from aerodrake.model.vehicle.kinematics import Kinematics
from aerodrake.model.vehicle.state import split_state
from aerodrake.scenario import Clik, Lissajous, Mpc
from aerodrake.systems.clik import ClikSystem
from aerodrake.systems.mpc import MpcSystem

CONFIG = Mpc(horizon=4, k_e=(3.0, 3.0, 3.0))


@pytest.fixture(scope="module")
def parts(vehicle):
    model = EquivalentModel.make("velocity_aware", np.ones(3), 0.02, vehicle.joints)
    return model, vehicle


@pytest.fixture
def clik(parts) -> ClikSystem:
    return ClikSystem(InverseKinematics(Clik(), CONFIG, *parts))


@pytest.fixture
def values(vehicle, parts):
    """Values of the input ports: at rest in trim, 5 cm from the target."""
    state, n = vehicle.trim_state, vehicle.joints
    end_effector = Kinematics(vehicle.plant).end_effector(split_state(state))
    target = np.concatenate([end_effector.p_E + [0.05, 0, 0], np.zeros(3)])
    base = np.concatenate([vehicle.p_B, np.zeros(6)])
    arm = np.concatenate([vehicle.working, np.zeros(2 * n)])
    return {
        "state": state,
        "x_0": parts[0].initial_state(Signals(state[4:7], np.zeros(3), base, arm)),
        "end_effector": Value(end_effector),
        "base_setpoint": base,
        "joint_setpoint": arm,
        "horizon": np.tile(target, CONFIG.horizon + 1),
        "weights": np.array([1.0, 1.0, 1100.0, 9.9, 5.0]),
        "delta": np.zeros(3),
    }


def tick(clik, context, values) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    for port, value in values.items():
        clik.GetInputPort(port).FixValue(context, value)
    context.SetDiscreteState(clik.EvalUniquePeriodicDiscreteUpdate(context))
    return tuple(clik.GetOutputPort(port).Eval(context) for port in ("u", "prediction", "status"))


def test_has_the_ports_and_the_rate_of_the_mpc(clik, parts):
    mpc = MpcSystem(MpcFormulation(CONFIG, *parts))

    def ports(system):
        inputs = map(system.get_input_port, range(system.num_input_ports()))
        outputs = map(system.get_output_port, range(system.num_output_ports()))
        return [(port.get_name(), port.size()) for side in (inputs, outputs) for port in side]

    # CLIK has no orientation task and a shorter plan.
    own = ("pointing", "plan")
    shared = [port for port in ports(mpc) if port[0] not in own]
    m = 3 + clik.GetInputPort("joint_setpoint").size() // 3
    assert ports(clik) == [*shared, ("plan", 2 * m)]
    assert not clik.HasAnyDirectFeedthrough()
    timing = clik.GetUniquePeriodicDiscreteUpdateAttribute()
    assert (timing.period_sec(), timing.offset_sec()) == (0.02, 0)


def test_a_tick_is_the_command_of_the_equations(clik, parts, values):
    context = clik.CreateDefaultContext()
    u, prediction, status = tick(clik, context, values)
    inverse = InverseKinematics(Clik(), CONFIG, *parts)
    command = inverse.command(clik.tick_inputs(context))
    np.testing.assert_array_equal(u, command.u)
    np.testing.assert_array_equal(
        prediction, inverse.predict(clik.tick_inputs(context), command.velocity).ravel()
    )
    np.testing.assert_array_equal(clik.GetOutputPort("plan").Eval(context), [*u, *u])
    assert tuple(status) == (QpStatus.UNCONSTRAINED, 0, 0) and not command.is_clipped


def test_a_clipped_command_has_status_solved(clik, values):
    values["horizon"] = values["horizon"] + 1.0
    _, _, status = tick(clik, clik.CreateDefaultContext(), values)
    assert status[0] == QpStatus.SOLVED


@pytest.mark.parametrize("port", ["state", "x_0", "horizon", "weights"])
def test_nan_inputs_command_zero_acceleration_once(clik, values, port):
    context = clik.CreateDefaultContext()
    broken = values | {port: np.full(len(values[port]), np.nan)}
    u, _, status = tick(clik, context, broken)
    np.testing.assert_array_equal(u, np.zeros_like(u))
    assert status[0] == QpStatus.NON_FINITE
    fresh = tick(clik, clik.CreateDefaultContext(), values)
    for ours, expected in zip(tick(clik, context, values), fresh, strict=True):
        np.testing.assert_array_equal(ours, expected)


def test_flies_in_place_of_the_mpc(scenario):
    """Tracks to 1 cm within all bounds."""
    path = Lissajous(amplitude_m=(0.2, 0.15, 0.1), period_s=(10.0, 8.0, 12.0), start_s=1.0)
    mpc = replace(scenario.mpc, k_e=CONFIG.k_e)
    flown = replace(
        scenario, controller="clik", mpc=mpc, settle_s=0.1, duration=3.0, reference=path
    )
    log = FlightSimulation(flown).fly()
    assert log.exit_reason == "completed" and len(log["tick_ms"]) == 155
    assert np.ptp(log["p_Ed_m"], axis=0).max() > 0.1
    assert log.error_m.max() < 0.01
    assert set(log["qp_status"]) == {QpStatus.UNCONSTRAINED}
