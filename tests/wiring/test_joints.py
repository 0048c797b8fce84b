"""Systems between the arm controller and the links."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from aerodrake.model.vehicle.state import split_state
from aerodrake.scenario import Actuation, JointDegraded, Mismatch
from aerodrake.station import make_context, make_station
from tests.trim import hovering

EVERYTHING = {
    "actuation": Actuation(
        coulomb_n_m=(0.05,), backlash_rad=(0.004,), flexibility_rad_n_m=(0.001,)
    ),
    "mismatch": Mismatch(torque_scale=0.9),
    "faults": (JointDegraded(joint=1, remaining=0.9, start_s=-60.0, duration_s=3600.0),),
}


def names(station) -> set[str]:
    return {system.get_name() for system in station.GetSystems()}


def test_each_flaw_adds_its_system(scenario, vehicle):
    silent = names(make_station(scenario, vehicle=vehicle))
    everything = names(make_station(replace(scenario, **EVERYTHING), vehicle=vehicle))
    added = {"joint_friction", "joint_transmission", "joint_motors", "joint_faults"}
    assert everything - silent == added
    assert not silent & added


@pytest.fixture(scope="module")
def hover(scenario, vehicle):
    """Station with all of them, and its Context after 2.5 s of hover."""
    station = make_station(replace(scenario, **EVERYTHING), vehicle=vehicle)
    context = make_context(station, 0)
    for name, value in zip(("base_setpoint", "joint_setpoint"), hovering(vehicle), strict=True):
        station.GetInputPort(name).FixValue(context, value)
    Simulator(station, context).AdvanceTo(2.5)
    return station, context


def test_the_torque_passes_faults_motors_transmission_and_friction(hover, vehicle):
    station, context = hover

    def torque(name: str, port: str) -> np.ndarray:
        system = station.GetSubsystemByName(name)
        return system.GetOutputPort(port).Eval(system.GetMyContextFromRoot(context))

    command = torque("arm_controller", "joint_torque")
    degraded = command * [1, 0.9, 1, 1, 1, 1]
    np.testing.assert_allclose(torque("joint_faults", "y0"), degraded)
    scaled = vehicle.trim_torque + 0.9 * (degraded - vehicle.trim_torque)
    np.testing.assert_allclose(torque("joint_motors", "y0"), scaled, atol=1e-12)
    friction = torque("joint_friction", "joint_torque")
    passed = torque("joint_transmission", "joint_torque")
    assert np.abs(friction - passed).max() <= 0.05 + 1e-9
    assert np.any(friction != passed)
    np.testing.assert_array_equal(station.GetOutputPort("joint_torque").Eval(context), friction)


def test_encoders_measure_the_motors(hover, vehicle):
    """The controller brings the motors to the setpoints, and leaves the links beside them."""
    station, context = hover
    measured, true = (
        split_state(station.GetOutputPort(name).Eval(context)).q
        for name in ("sample", "true_state")
    )
    twist = 0.001 * vehicle.trim_torque + 0.002 * np.sign(vehicle.trim_torque)
    loaded = np.abs(vehicle.trim_torque) > 0.1
    np.testing.assert_allclose((measured - true)[loaded], twist[loaded], atol=2e-4)
    np.testing.assert_allclose(measured[loaded], vehicle.working[loaded], atol=5e-4)
