"""Trim of a vehicle: its setpoints, and the facts of a VehicleModel as numbers."""

from dataclasses import fields

import numpy as np

from aerodrake.model.vehicle.vehicle import VehicleModel

OBJECTS = {"description", "plant", "ground_geometry", "rotors"}
"""Fields of a VehicleModel that are neither numbers nor names."""


def hovering(vehicle):
    """Returns base setpoint and joint setpoint of trim."""
    n = vehicle.joints
    return np.r_[vehicle.p_B, np.zeros(6)], np.r_[vehicle.working, np.zeros(2 * n)]


def assert_same_vehicle(vehicle: VehicleModel, other: VehicleModel) -> None:
    """Asserts that two models have the same limits, inertia, trim and rotors."""
    for name in {field.name for field in fields(VehicleModel)} - OBJECTS:
        np.testing.assert_array_equal(getattr(vehicle, name), getattr(other, name), err_msg=name)
    assert vehicle.feet_m == other.feet_m
    assert vehicle.description.document.toxml() == other.description.document.toxml()
    np.testing.assert_array_equal(vehicle.rotors.p_B, other.rotors.p_B)
