"""Friction on an arm in Drake's plant, without gravity and motors."""

import numpy as np
import pytest
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource

from aerodrake.model.vehicle.drake_parser import parse_urdf
from aerodrake.model.vehicle.robot import EXACT
from aerodrake.model.vehicle.state import split_state
from aerodrake.scenario import Actuation
from aerodrake.systems.joint_friction import make_joint_friction

STEP, COULOMB = 0.001, 0.02


class FloatingArm:
    """The vehicle in free flight without gravity, with friction in its joints."""

    def __init__(self, vehicle, config: Actuation):
        builder = DiagramBuilder()
        plant = builder.AddNamedSystem("plant", MultibodyPlant(STEP))
        parse_urdf(plant, vehicle.description.invisible_urdf(EXACT), vehicle.robot)
        plant.mutable_gravity_field().set_gravity_vector(np.zeros(3))
        plant.SetUseSampledOutputPorts(False)
        plant.Finalize()
        friction = builder.AddNamedSystem("friction", make_joint_friction(config, vehicle, STEP))
        zero = builder.AddSystem(ConstantVectorSource(np.zeros(vehicle.joints)))
        builder.Connect(zero.get_output_port(), friction.GetInputPort("motor_torque"))
        builder.Connect(plant.get_state_output_port(), friction.GetInputPort("true_state"))
        builder.Connect(friction.get_output_port(), plant.get_actuation_input_port())
        self._simulator = Simulator(builder.Build())
        self._plant = plant
        self._context = plant.GetMyMutableContextFromRoot(self._simulator.get_mutable_context())
        rates = np.linspace(-1.5, 2.0, vehicle.joints)
        plant.SetPositionsAndVelocities(self._context, vehicle.trim_state)
        plant.SetVelocities(self._context, np.concatenate([np.zeros(6), rates]))

    def advance(self, time: float) -> tuple[np.ndarray, float]:
        """Returns joint rates (n,) rad/s and kinetic energy in J at a time in s."""
        self._simulator.AdvanceTo(time)
        qdot = split_state(self._plant.get_state_output_port().Eval(self._context)).qdot
        return qdot.copy(), self._plant.CalcKineticEnergy(self._context)


def test_there_is_no_system_without_friction(vehicle):
    assert make_joint_friction(Actuation(), vehicle, STEP) is None


@pytest.mark.parametrize(
    "config", [Actuation(coulomb_n_m=(COULOMB,)), Actuation(viscous_n_m_s_rad=(20.0,))]
)
def test_the_arm_loses_energy_at_each_step_and_stops(vehicle, config):
    """The joints stop relative to each other; the vehicle turns on, as it does without gravity."""
    arm, energies = FloatingArm(vehicle, config), []
    for k in range(1, 400):
        energies.append(arm.advance(k * STEP + 1e-6)[1])
    assert np.diff(energies).max() < 1e-6 * energies[0]
    qdot, _ = arm.advance(3.0)
    assert np.abs(qdot).max() < 1e-4
