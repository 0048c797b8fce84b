"""The bare plant has no Python systems and hovers at the trim input."""

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import LeafSystem

from aerodrake.bench.bare_plant import make_bare_plant
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.station import make_closed_loop


def leaves(system):
    if hasattr(system, "GetSystems"):
        return [leaf for inner in system.GetSystems() for leaf in leaves(inner)]
    return [system]


def python_systems(diagram):
    return [s for s in leaves(diagram) if isinstance(s, LeafSystem) and "aerodrake" in str(type(s))]


def test_has_no_python_systems(scenario):
    diagram = make_bare_plant(scenario)
    names = {system.get_name() for system in leaves(diagram)}
    inputs = {"thrust_command", "joint_torque", "no_force"}
    assert names == {"multibody_plant", "scene_graph", "propellers", "rotors", *inputs}
    assert not python_systems(diagram)
    assert python_systems(make_closed_loop(scenario))


def test_hovers(scenario):
    diagram = make_bare_plant(scenario)
    simulator = Simulator(diagram)
    port = diagram.GetOutputPort("true_state")
    trim = VehicleModel.load(scenario).trim_state
    np.testing.assert_allclose(port.Eval(simulator.get_context()), trim)
    simulator.AdvanceTo(1.0)
    np.testing.assert_allclose(port.Eval(simulator.get_context()), trim, atol=1e-5)


def test_drifts_by_less_than_10_cm_in_10_s(scenario):
    diagram = make_bare_plant(scenario)
    simulator = Simulator(diagram)
    simulator.AdvanceTo(10.0)
    state = diagram.GetOutputPort("true_state").Eval(simulator.get_context())
    assert np.abs(state[4:7] - VehicleModel.load(scenario).p_B).max() < 0.1
