"""Station and closed loop: ports, and flights of each alone."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from aerodrake.model.supervision.conditions import conditions
from aerodrake.model.vehicle.kinematics import Kinematics
from aerodrake.scenario import Mpc, Supervisor
from aerodrake.station import make_closed_loop, make_context, make_coordinator, make_station
from tests.robots import multibody_plant
from tests.trim import hovering

N, JOINTS, ROTORS = 15, 6, 4
STATE = 13 + 2 * JOINTS
FEET_M = 0.38
"""Distance from the base's origin down to the bottom of its feet."""

STATION_OUTPUTS = {
    "state": STATE,
    "true_state": STATE,
    "thrust": ROTORS,
    "thrust_command": ROTORS,
    "joint_torque": JOINTS,
    "torque_at_limit": JOINTS,
    "sample": STATE,
    "external_acceleration": 3,
    "sample_health": 6,
    "joint_oscillation": JOINTS,
    "position_offset": 3,
    "specific_thrust": 1,
    "disturbance": 6,
    "saturated": 1,
    "rotor_effectiveness": ROTORS,
    "wind_force": 3,
    "wind_velocity": 3,
    "body_poses": 0,
}
SETPOINTS = {"base_setpoint": 9, "joint_setpoint": 3 * JOINTS}
COORDINATOR_OUTPUTS = SETPOINTS | {
    "segment": 3 * (3 + JOINTS) + 1,
    "reference": 6,
    "requested_reference": 6,
    "horizon": 6 * (N + 1),
    "reference_verdict": 1,
    "weights": 5,
    "u": 3 + JOINTS,
    "plan": Mpc().span_ticks * (3 + JOINTS),
    "prediction": 3 * (N + 1),
    "status": 3,
    "delta": 3,
    "prediction_error": 3,
    "nominal_prediction_error": 3,
    "learner_health": 2,
    "delta_source": 1,
    "stable_learning_rate": 1,
    "mode": 1,
    "cause": 1,
    "conditions": len(conditions(Supervisor())),
}


@pytest.fixture(scope="module")
def station(scenario):
    return make_station(scenario)


@pytest.fixture(scope="module")
def closed_loop(scenario):
    return make_closed_loop(scenario)


def ports(diagram) -> tuple[dict[str, int], dict[str, int]]:
    """Returns the sizes of inputs and of outputs by name."""
    inputs = map(diagram.get_input_port, range(diagram.num_input_ports()))
    outputs = map(diagram.get_output_port, range(diagram.num_output_ports()))
    return ({p.get_name(): p.size() for p in inputs}, {p.get_name(): p.size() for p in outputs})


def test_ports(station, closed_loop, scenario):
    coordinator = make_coordinator(replace(scenario, mpc=replace(scenario.mpc, horizon=N)))
    assert ports(station) == (SETPOINTS, STATION_OUTPUTS)
    inputs = {"state": STATE, "external_acceleration": 3, "specific_thrust": 1}
    inputs |= {"disturbance": 6, "saturated": 1}
    inputs |= {"joint_oscillation": JOINTS, "torque_at_limit": JOINTS}
    inputs |= {"sample_health": 6, "position_offset": 3, "rotor_effectiveness": ROTORS}
    # Connected only over a wire.
    inputs |= {"followed": 3 * (3 + JOINTS) + 1}
    assert ports(coordinator) == (inputs, COORDINATOR_OUTPUTS)
    assert scenario.mpc.horizon == N
    assert ports(closed_loop) == ({}, STATION_OUTPUTS | COORDINATOR_OUTPUTS)


def test_the_closed_loop_consists_of_station_and_coordinator(closed_loop):
    names = [system.get_name() for system in closed_loop.GetSystems()]
    assert sorted(names) == ["coordinator", "station"]
    assert closed_loop.get_name() == "closed_loop"


def fly(station, setpoints, duration: float, step: float = 0.01) -> np.ndarray:
    """Returns true states (samples, 13 + 2 n), every `step` s, from trim.

    Args:
        setpoints: Function from time to (base setpoint, joint setpoint).
    """
    context = make_context(station, 0)
    simulator = Simulator(station, context)
    states = []
    for k in range(round(duration / step)):
        base, joints = setpoints(k * step)
        station.GetInputPort("base_setpoint").FixValue(context, base)
        station.GetInputPort("joint_setpoint").FixValue(context, joints)
        simulator.AdvanceTo((k + 1) * step)
        states.append(station.GetOutputPort("true_state").Eval(context))
    return np.array(states)


def minimum_jerk(t: float, duration: float) -> tuple[float, float, float]:
    """Returns position, velocity and acceleration of the smooth motion from 0 to 1."""
    s = min(max(t / duration, 0.0), 1.0)
    return (
        10 * s**3 - 15 * s**4 + 6 * s**5,
        (30 * s**2 - 60 * s**3 + 30 * s**4) / duration,
        (60 * s - 180 * s**2 + 120 * s**3) / duration**2,
    )


def swing(vehicle, target, t: float, duration: float) -> np.ndarray:
    """Returns the joint setpoint (3 n,) of a smooth motion from the working one to `target`."""
    way = np.asarray(target) - vehicle.working
    p, v, a = minimum_jerk(t, duration)
    return np.concatenate([vehicle.working + p * way, v * way, a * way])


def test_trim_stays_put(station, vehicle):
    states = fly(station, lambda t: hovering(vehicle), 2.0)
    np.testing.assert_allclose(states, np.tile(vehicle.trim_state, (len(states), 1)), atol=1e-6)


@pytest.mark.parametrize("interface", ["trajectory", "position"])
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_base_step(scenario, vehicle, interface, axis):
    base, joints = hovering(vehicle)
    base[axis] += 0.5
    flight = replace(scenario.flight, interface=interface)
    states = fly(make_station(replace(scenario, flight=flight)), lambda t: (base, joints), 5.0)
    error = np.abs(states[:, 4:7] - base[:3])
    assert error[0, axis] > 0.49
    assert np.all(error[-1] < 0.01)
    assert np.delete(error, axis, axis=1).max() < 0.05
    assert (states[:, 4 + axis] - base[axis]).max() < 0.05  # Little overshoot.


def test_the_vehicle_is_lifted_by_the_thrust_of_lagging_rotors(station, vehicle):
    """Newton's law for the centre of mass in the first milliseconds of a climb."""
    context = make_context(station, 0)
    base, joints = hovering(vehicle)
    base[2] += 0.3
    station.GetInputPort("base_setpoint").FixValue(context, base)
    station.GetInputPort("joint_setpoint").FixValue(context, joints)
    simulator = Simulator(station, context)
    plant = multibody_plant(station)
    plant_context = plant.GetMyContextFromRoot(context)

    def total(port):
        return station.GetOutputPort(port).Eval(context).sum()

    def climb():
        return plant.CalcCenterOfMassTranslationalVelocityInWorld(plant_context)[2]

    simulator.AdvanceTo(0.005)
    assert total("thrust_command") > total("thrust") + 1.0
    before, lift = climb(), total("thrust")
    simulator.AdvanceTo(0.006)
    assert (climb() - before) / 0.001 == pytest.approx(lift / 3.8 - 9.81, abs=1e-3)


def test_saturation_is_output_from_the_command_after_the_sample(station, vehicle):
    """From half a plant step after it, until a command is within limits again."""
    context = make_context(station, 0)
    base, joints = hovering(vehicle)
    base[2] += 10.0
    station.GetInputPort("base_setpoint").FixValue(context, base)
    station.GetInputPort("joint_setpoint").FixValue(context, joints)
    simulator = Simulator(station, context)
    saturated = station.GetOutputPort("saturated")
    assert saturated.Eval(context) == 0
    simulator.AdvanceTo(0.0004)
    assert saturated.Eval(context) == 0
    simulator.AdvanceTo(0.0006)
    assert saturated.Eval(context) == 1
    base[2:] = vehicle.p_B[2], *np.zeros(6)
    station.GetInputPort("base_setpoint").FixValue(context, base)
    simulator.AdvanceTo(0.0104)
    assert saturated.Eval(context) == 1
    simulator.AdvanceTo(1.0)
    assert saturated.Eval(context) == 0


@pytest.mark.parametrize("joint", range(JOINTS))
def test_a_motion_of_one_joint_hardly_moves_the_base(station, vehicle, joint):
    """1 rad in 1 s, towards the middle of the joint's range."""
    target = vehicle.working.copy()
    middle = (vehicle.lower[joint] + vehicle.upper[joint]) / 2
    target[joint] += 1.0 if target[joint] <= middle else -1.0
    base, _ = hovering(vehicle)
    states = fly(station, lambda t: (base, swing(vehicle, target, t, 1.0)), 2.0, step=0.005)
    assert np.abs(states[:, 4:7] - vehicle.p_B).max() < 0.05
    q = states[:, 7 : 7 + JOINTS]
    np.testing.assert_allclose(q[-1], target, atol=1e-3)
    assert np.abs(q[199] - target).max() < 0.02  # At the end of the swing itself.


def test_lands_on_its_feet(station, vehicle):
    """Folds its arm, and descends to a setpoint below the ground."""
    folded = np.array([0.0, -1.5, 2.6, 0.0, 1.5, 0.0])
    base, _ = hovering(vehicle)

    def setpoints(t):
        sinking = max(0.0, t - 1.5)
        base[2], base[5] = max(1.5 - 0.5 * sinking, 0.2), -0.5 if 0 < sinking < 2.6 else 0.0
        return base, swing(vehicle, folded, t, 1.5)

    states = fly(station, setpoints, 6.0)
    z = states[:, 6]
    assert z.min() > FEET_M - 2e-3
    landed = z < FEET_M + 1e-3
    first = int(np.argmax(landed))
    assert 3.0 < 0.01 * first < 5.0
    assert z[first:].max() < FEET_M + 5e-3  # It does not bounce.
    assert states[-1, 6] == pytest.approx(FEET_M, abs=1e-3)
    np.testing.assert_allclose(states[-1, 4:6], 0, atol=0.02)
    np.testing.assert_allclose(states[-1, 1:4], 0, atol=1e-3)  # Level, heading as before.
    np.testing.assert_allclose(states[-1, 13:], 0, atol=1e-4)


def test_the_closed_loop_starts_in_trim(closed_loop, scenario, vehicle):
    context = make_context(closed_loop, scenario.seed)
    for port, expected in (
        ("state", vehicle.trim_state),
        ("true_state", vehicle.trim_state),
        ("base_setpoint", hovering(vehicle)[0]),
        ("joint_setpoint", hovering(vehicle)[1]),
        ("joint_torque", vehicle.trim_torque),
    ):
        value = closed_loop.GetOutputPort(port).Eval(context)
        np.testing.assert_allclose(value, expected, atol=1e-12, err_msg=port)
    thrust = closed_loop.GetOutputPort("thrust").Eval(context)
    np.testing.assert_allclose(thrust, closed_loop.GetOutputPort("thrust_command").Eval(context))
    assert thrust.sum() == pytest.approx(3.8 * 9.81)


def test_the_closed_loop_hovers_where_it_started(closed_loop, scenario, vehicle):
    """Through the settling time and past it."""
    context = make_context(closed_loop, scenario.seed)
    Simulator(closed_loop, context).AdvanceTo(scenario.settle_s + 0.5)
    state = closed_loop.GetOutputPort("true_state").Eval(context)
    np.testing.assert_allclose(state, vehicle.trim_state, atol=1e-6)
    p_EB, _ = Kinematics(vehicle.plant).arm(state[7:13])
    p_Ed = closed_loop.GetOutputPort("reference").Eval(context)[:3]
    np.testing.assert_allclose(state[4:7] + p_EB, p_Ed, atol=1e-6)
