"""Closed loops that together contain every system of the package."""

from collections.abc import Iterator
from importlib.util import find_spec

from pydrake.lcm import DrakeLcm
from pydrake.systems.framework import Diagram

from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import (
    Accelerometer,
    Actuation,
    Air,
    FixedAxis,
    JointDegraded,
    JointSensors,
    LearnerPoisoned,
    MpcMissed,
    Physics,
    PositionSensor,
    Push,
    ReferenceNan,
    Residual,
    RotorDegraded,
    SampleNan,
    Scenario,
    Sensors,
    ToolSensor,
    Wind,
)
from aerodrake.station import make_closed_loop
from aerodrake.wire.remote_coordinator import make_remote_coordinator, make_station_link


def every_loop() -> Iterator[Diagram]:
    """Yields the diagrams one by one; the first is the closed loop of the default scenario.

    Without the extra `[mujoco]` none contains MuJoCo's plant.
    """
    yield make_closed_loop(Scenario())
    yield _all_tasks()
    yield _all_flaws()
    yield make_closed_loop(Scenario(controller="clik"))
    if find_spec("mujoco"):
        yield make_closed_loop(Scenario(physics=Physics(engine="mujoco")))
    yield _station_end()


def _all_tasks() -> Diagram:
    in_station = (SampleNan(), RotorDegraded(), JointDegraded(), Push())
    faults = (*in_station, MpcMissed(), LearnerPoisoned(), ReferenceNan())
    residual, sensors = Residual(mode="online"), Sensors(base_delay_s=0.01)
    tasks = {"orientation": FixedAxis(), "residual": residual, "sensors": sensors}
    return make_closed_loop(Scenario(faults=faults, **tasks))


def _all_flaws() -> Diagram:
    sensors = Sensors(
        position=PositionSensor(latency_s=(0.0, 0.01)),
        joints=JointSensors(resolution_bits=12),
        accelerometer=Accelerometer(period_s=0.005),
        tool=ToolSensor(period_s=0.02),
    )
    actuation = Actuation(
        rotor_dead_time_s=0.005,
        rotor_levels=1000,
        thrust_scatter=0.05,
        sag=0.1,
        coulomb_n_m=(0.1,),
        backlash_rad=(0.003,),
        setpoint_latency_s=(0.0, 0.02),
    )
    wind = Wind(velocity_m_s=(1.0, 0.0, 0.0), shear_exponent=0.2)
    air = Air(rotor_drag_n_s_m=0.2)
    return make_closed_loop(Scenario(sensors=sensors, actuation=actuation, wind=wind, air=air))


def _station_end() -> Diagram:
    scenario = Scenario()
    link = make_station_link(scenario, DrakeLcm("memq://"))
    remote = make_remote_coordinator(scenario, VehicleModel.load(scenario), link)
    remote.set_name("remote_coordinator")
    return remote
