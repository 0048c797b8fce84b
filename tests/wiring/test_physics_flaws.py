"""Flaws of the rotors, and effects of the air on them, in the physics."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from aerodrake.model.low_level.thrust_allocation import trim_thrust
from aerodrake.model.vehicle.rotor_air import ground_ratio
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Actuation, Air, RotorDegraded, Scenario, Wind
from aerodrake.systems.rotor_strength import thrust_factors
from aerodrake.wiring.physics import make_physics

SILENT = {"plant", "rotors", "wind", "forces"}
LEVELS = 100


class Physics:
    """Physics of a scenario that hovers with the commands of trim."""

    def __init__(self, scenario: Scenario, vehicle: VehicleModel):
        self.trim = trim_thrust(vehicle, scenario.vehicle.rotor)
        self.diagram = make_physics(scenario, vehicle)
        self.names = {system.get_name() for system in self.diagram.GetSystems()}
        self._simulator = Simulator(self.diagram)
        self.context = self._simulator.get_mutable_context()
        self.command(self.trim)
        n = vehicle.joints
        for name, value in (
            ("joint_torque", vehicle.trim_torque),
            ("external_force", np.zeros(6 + n)),
        ):
            self.diagram.GetInputPort(name).FixValue(self.context, value)

    def command(self, thrust: np.ndarray) -> None:
        self.diagram.GetInputPort("thrust_command").FixValue(self.context, thrust)

    def thrust(self, time: float) -> np.ndarray:
        self._simulator.AdvanceTo(time)
        return self.diagram.GetOutputPort("thrust").Eval(self.context).copy()


@pytest.fixture
def make(scenario, vehicle):
    return lambda **sections: Physics(replace(scenario, **sections), vehicle)


def test_silent_flaws_add_no_system(make):
    assert make().names == SILENT
    assert make(air=Air(), actuation=Actuation()).names == SILENT


def test_the_dead_time_delays_the_thrust(make):
    prompt, late = make(), make(actuation=Actuation(rotor_dead_time_s=0.005))
    for physics in (prompt, late):
        physics.thrust(0.0102)
        physics.command(physics.trim + 2.0)
    np.testing.assert_array_equal(late.thrust(0.0158), late.trim)
    np.testing.assert_allclose(late.thrust(0.0232), prompt.thrust(0.0182), rtol=1e-12)


def test_commands_have_levels_after_the_dead_time(make):
    levels = make(actuation=Actuation(rotor_levels=LEVELS, rotor_dead_time_s=0.002))
    assert levels.names == SILENT | {"rotor_levels", "rotor_dead_time"}
    thrust, step = levels.thrust(1.0), 20.0 / LEVELS
    np.testing.assert_allclose(thrust, step * np.round(levels.trim / step), rtol=1e-9)


def test_scatter_sag_and_faults_multiply(make, scenario):
    fault = RotorDegraded(rotor=1, remaining=0.5, start_s=-60.0, duration_s=3600.0)
    flaws = Actuation(thrust_scatter=0.05, sag=0.2)
    flown = make(actuation=flaws, faults=(fault,), settle_s=0.0, duration=1.0)
    assert flown.names == SILENT | {"rotor_strength", "rotor_faults"}
    expected = flown.trim * thrust_factors(replace(scenario, actuation=flaws), 4) * 0.9
    np.testing.assert_allclose(flown.thrust(0.5), expected * [1, 0.5, 1, 1], rtol=1e-12)


def test_the_ground_effect_acts_on_the_thrust_of_the_rotors(make, vehicle):
    air = make(air=Air(rotor_radius_m=0.2))
    height = vehicle.p_B[2] + vehicle.rotors.p_B[0, 2]
    np.testing.assert_allclose(air.thrust(0.0), ground_ratio(0.2, height) * air.trim)


def test_the_rotors_drag_pushes_the_base_with_the_wind(make, vehicle):
    """The acceleration of the centre of mass is drag over mass, and it is that of a still arm."""
    still = Wind(quadratic_drag_n_s2_m2=0.0, linear_drag_n_s_m=0.0, velocity_m_s=(2.0, 0.0, 0.0))
    found = []
    for air in (Air(), Air(rotor_drag_n_s_m=0.3)):
        physics = make(air=air, wind=still)
        plant = physics.diagram.GetSubsystemByName("plant").GetSubsystemByName("multibody_plant")
        physics.thrust(0.010)
        inner = plant.GetMyContextFromRoot(physics.context)
        found.append(plant.CalcCenterOfMassTranslationalVelocityInWorld(inner))
    np.testing.assert_allclose(found[0], 0, atol=1e-9)
    assert found[1][0] == pytest.approx(0.3 * 2.0 / vehicle.mass * 0.010, rel=2e-3)
