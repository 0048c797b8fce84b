"""Torques that hold arm and payload, beside their limits."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.multibody.plant import MultibodyPlant

from aerodrake.model.low_level.holding_torque import holding_torque, torque_notes
from aerodrake.model.vehicle.robot import add_payload, add_robot
from aerodrake.scenario import Mismatch, Payload, Scenario


def test_agrees_with_the_gravity_of_the_plant_with_payload_and_mismatch(vehicle):
    scenario = Scenario(payload=Payload(mass_kg=0.7), mismatch=Mismatch(mass_scale=1.3))
    plant = MultibodyPlant(0.0)
    add_robot(plant, vehicle.description, scenario.mismatch)
    add_payload(plant, 0.7)
    plant.Finalize()
    context = plant.CreateDefaultContext()
    plant.SetPositions(context, vehicle.trim_state[: plant.num_positions()])
    gravity = plant.CalcGravityGeneralizedForces(context)[6:]
    np.testing.assert_allclose(holding_torque(scenario, vehicle), -gravity, atol=1e-9)


@pytest.mark.parametrize(
    ("mass_kg", "expected"),
    [
        (0.5, []),
        (
            1.0,
            [
                "elbow_pitch needs 2.8 N m of its 3 N m to hold the arm and payload.mass_kg (1 kg) "
                "in hover: little is left to move it"
            ],
        ),
        (
            1.5,
            [
                "shoulder_pitch needs 3.46 N m of its 4 N m to hold the arm and payload.mass_kg "
                "(1.5 kg) in hover: little is left to move it",
                "elbow_pitch needs 3.87 N m of its 3 N m to hold the arm and payload.mass_kg "
                "(1.5 kg) in hover: it falls",
            ],
        ),
    ],
)
def test_notes_name_joints_near_their_limit(vehicle, mass_kg, expected):
    assert torque_notes(Scenario(payload=Payload(mass_kg=mass_kg)), vehicle) == expected


def test_a_weak_joint_without_payload(scenario, vehicle):
    effort = vehicle.effort.copy()
    effort[2] = 1.1 * vehicle.trim_torque[2]
    (note,) = torque_notes(scenario, replace(vehicle, effort=effort))
    assert note.startswith("elbow_pitch needs") and "to hold the arm in hover: little" in note
