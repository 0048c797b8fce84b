"""Backlash and flexibility of the joints as a system."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from aerodrake.model.vehicle.state import split_state
from aerodrake.scenario import Actuation
from aerodrake.systems.joint_transmission import make_joint_transmission

STEP = 0.001
CONFIG = Actuation(backlash_rad=(0.01,), flexibility_rad_n_m=(0.02,))


def test_there_is_no_system_for_rigid_joints(vehicle):
    assert make_joint_transmission(Actuation(), vehicle, STEP) is None


def test_trim_is_an_equilibrium_with_the_motors_ahead_of_the_links(vehicle):
    transmission = make_joint_transmission(CONFIG, vehicle, STEP)
    simulator, trim = Simulator(transmission), vehicle.trim_torque
    context = simulator.get_mutable_context()
    transmission.GetInputPort("motor_torque").FixValue(context, trim)
    transmission.GetInputPort("true_state").FixValue(context, vehicle.trim_state)
    simulator.AdvanceTo(0.05)
    torque, measured = (
        transmission.GetOutputPort(name).Eval(context) for name in ("joint_torque", "encoder_state")
    )
    np.testing.assert_allclose(torque, trim, atol=1e-12)
    expected = split_state(vehicle.trim_state.copy())
    expected.q[:] += 0.02 * trim + 0.005 * np.sign(trim) * (np.abs(trim) > 0.1)
    np.testing.assert_allclose(measured, expected.to_vector(), atol=1e-12)


@pytest.mark.parametrize("torque", [0.3, -0.3])
def test_a_torque_turns_the_motor_first_and_then_the_link(vehicle, torque):
    transmission = make_joint_transmission(CONFIG, vehicle, STEP)
    simulator = Simulator(transmission)
    context = simulator.get_mutable_context()
    motor = np.zeros(vehicle.joints)
    motor[0] = torque
    transmission.GetInputPort("motor_torque").FixValue(context, motor)
    transmission.GetInputPort("true_state").FixValue(context, vehicle.trim_state)
    assert transmission.GetOutputPort("joint_torque").Eval(context)[0] == pytest.approx(0)
    encoder_state = transmission.GetOutputPort("encoder_state")
    simulator.AdvanceTo(1.0)
    assert transmission.GetOutputPort("joint_torque").Eval(context)[0] == pytest.approx(torque)
    twist = split_state(encoder_state.Eval(context)).q[0] - vehicle.working[0]
    assert twist == pytest.approx(0.02 * torque + np.copysign(0.005, torque))
