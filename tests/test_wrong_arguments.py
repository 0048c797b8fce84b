"""Constructors of systems and diagrams refuse wrong arguments, and name them."""

import inspect
import re
from dataclasses import replace

import numpy as np
import pytest
from pydrake.systems.framework import LeafSystem

from aerodrake.coordinator import make_coordinator
from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.model.mpc.clik import InverseKinematics
from aerodrake.model.mpc.formulation import MpcFormulation
from aerodrake.model.reference.curves import make_reference
from aerodrake.model.reference.direction import make_direction
from aerodrake.model.sensing.state_filter import StateFilter
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import (
    Allocation,
    Arm,
    Clik,
    Clover,
    Filter,
    Flight,
    Mismatch,
    Mpc,
    Residual,
    Rotor,
    SampleNan,
    Sensors,
    Wind,
)
from aerodrake.station import make_closed_loop, make_context, make_station
from aerodrake.support.errors import BadInput
from aerodrake.systems.arm_controller import ArmController
from aerodrake.systems.faults.actuators import make_pushes
from aerodrake.systems.faults.samples import SampleFaultSystem
from aerodrake.systems.flight_controller import FlightController
from aerodrake.systems.mpc import MpcSystem
from aerodrake.systems.residual_estimator import ResidualEstimator
from aerodrake.systems.rotors import make_rotors
from aerodrake.systems.sensors import SensorSystem
from aerodrake.systems.weight_allocator import WeightAllocator
from aerodrake.systems.wind_force import WindForce
from aerodrake.wiring.sensors import make_sensors
from aerodrake.wiring.wind import make_wind
from tests.modules import SYSTEMS

NAN = float("nan")


@pytest.mark.parametrize("system", SYSTEMS, ids=lambda system: system.__name__)
def test_every_constructor_checks_its_arguments(system):
    assert issubclass(system, LeafSystem) and hasattr(system.__init__, "__wrapped__")
    assert "self" in inspect.signature(system.__init__).parameters


@pytest.mark.parametrize(
    ("make", "expected"),
    [
        (lambda v: WeightAllocator(Allocation(), 0), "period: expected more than 0 s, got 0"),
        (
            lambda v: WeightAllocator(Allocation(), -0.02),
            "period: expected more than 0 s, got -0.02",
        ),
        (lambda v: WeightAllocator(Allocation(), NAN), "period: expected a number, got nan"),
        (lambda v: WeightAllocator(Allocation(), "1"), "period: expected a number, got '1'"),
        (lambda v: WeightAllocator(Allocation(), True), "period: expected a number, got True"),
        (lambda v: WeightAllocator(Mpc(), 0.02), "config: expected Allocation, got Mpc("),
        (lambda v: WeightAllocator(None, 0.02), "config: expected Allocation, got None"),
        (
            lambda v: FlightController(Flight(), Rotor(), v, 0.0, 0.0),
            "period: expected more than 0 s",
        ),
        (
            lambda v: FlightController(Flight(), Rotor(), v, 0.01, -1),
            "offset: expected 0 or more s",
        ),
        (
            lambda v: FlightController(Mpc(), Rotor(), v, 0.01, 0.0),
            "config: expected Flight, got Mpc(",
        ),
        (
            lambda v: FlightController(Flight(), Rotor(), None, 0.01, 0.0),
            "vehicle: expected VehicleModel",
        ),
        (
            lambda v: ArmController(Arm(), v, 0, 0),
            "period: expected more than 0 s, got 0",
        ),
        (lambda v: MpcSystem(Mpc()), "formulation: expected MpcFormulation, got Mpc("),
        (lambda v: ResidualEstimator(None, None, Residual()), "model: expected EquivalentModel"),
        (
            lambda v: StateFilter.make(Filter(), Sensors(), 0.0),
            "dt: expected more than 0 s, got 0.0",
        ),
        (lambda v: MpcFormulation(Allocation(), v, v), "config: expected Mpc, got Allocation("),
        (lambda v: InverseKinematics(Mpc(), Clik(), v, v), "config: expected Clik, got Mpc("),
        (lambda v: VehicleModel.load("clover"), "scenario: expected Scenario, got 'clover'"),
        (lambda v: make_reference(Mpc(), np.zeros(3)), "config: expected Hover or Clover or"),
        (lambda v: make_reference(Clover(), np.zeros(2)), "start: expected an array of 3 numbers"),
        (lambda v: make_direction(Clover()), "config: expected OrientationOff or FixedAxis or"),
        (
            lambda v: EquivalentModel.make("papr", np.ones(3), 0.02, 6),
            "kind: unknown value 'papr'; did",
        ),
        (
            lambda v: EquivalentModel.make("paper", np.ones(2), 0.02, 6),
            "k_b: expected an array of 3 num",
        ),
        (
            lambda v: SensorSystem(Sensors(), 6, 0.01, 0.0, v.trim_wrench),
            "initial: expected an array of 13 + 2 n numbers, got 4",
        ),
        (
            lambda v: SensorSystem(Sensors(), 5, 0.01, 0.0, v.trim_state),
            "initial: expected 23 numbers",
        ),
        (
            lambda v: SensorSystem(Sensors(), 0, 0.01, 0.0, v.trim_state),
            "joints: expected 1 or more",
        ),
        (
            lambda v: SensorSystem(Sensors(), 6.0, 0.01, 0.0, v.trim_state),
            "joints: expected a whole",
        ),
        (lambda v: WindForce(Wind(), 6, 0.01, 1), "is_windy: expected bool, got 1"),
        (
            lambda v: SampleFaultSystem(SampleNan(), 0.0, NAN, 25),
            "period: expected a number",
        ),
        (
            lambda v: make_rotors(Rotor(), Mismatch(), v.trim_wrench, 0.001),
            "trim: expected the thrust of each rotor in [0, 20] N, got [37.2",
        ),
        (
            lambda v: make_rotors(Rotor(), Mismatch(), np.ones((4, 1)), 0.001),
            "trim: expected an array",
        ),
        (
            lambda v: make_rotors(Rotor(), Mismatch(), [9.0, NAN, 9.0, 9.0], 0.001),
            "trim: expected an arr",
        ),
        (
            lambda v: make_rotors(Mismatch(), Rotor(), np.ones(4), 0.001),
            "config: expected Rotor, got Mis",
        ),
        (lambda v: make_pushes(Clover(), 6), "scenario: expected Scenario, got Clover("),
        (lambda v: make_wind(Wind(), 6, 0.0), "period: expected more than 0 s, got 0.0"),
    ],
)
def test_a_wrong_argument_is_named(vehicle, make, expected):
    with pytest.raises(BadInput, match=rf"^[\w.]+: {re.escape(expected)}"):
        make(vehicle)


@pytest.mark.parametrize("make", [make_station, make_coordinator, make_closed_loop])
def test_diagrams_need_a_scenario(make):
    for wrong in ("clover", None, Mpc()):
        with pytest.raises(BadInput, match=f"^{make.__name__}: scenario: expected Scenario, got"):
            make(wrong)


def test_diagrams_need_replacements_by_their_class(scenario, vehicle):
    with pytest.raises(BadInput, match="make_station: replacements: expected Replacements or"):
        make_station(scenario, {"mpc": None}, vehicle)
    with pytest.raises(BadInput, match="^make_coordinator: vehicle: expected VehicleModel or None"):
        make_coordinator(scenario, None, scenario.vehicle)
    with pytest.raises(BadInput, match=r"make_sensors: trim_state: expected an array of 13 \+ 2"):
        make_sensors(scenario, vehicle.trim_wrench, np.zeros(6))


@pytest.mark.parametrize("seed", [-1, 2**31, 1.5, None, True, "0"])
def test_seeds_are_whole_numbers_in_their_range(seed):
    diagram = make_wind(Wind(), 6, 0.01)
    with pytest.raises(BadInput, match="^make_context: seed: expected a"):
        make_context(diagram, seed)
    make_context(diagram, np.int64(3))
    assert replace(Wind()) == Wind()
