"""EquivalentState: at a tick, from tick to tick, and after NaN."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from scipy.spatial.transform import Rotation

from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.model.vehicle.state import split_state
from aerodrake.scenario import Model, Scenario
from aerodrake.systems.equivalent_state import EquivalentState

DT, G = 0.02, 9.81
HIDDEN = ("alpha", "w")


def make(vehicle, kind: str = "flight") -> tuple[EquivalentModel, EquivalentState]:
    model = EquivalentModel.of(Scenario(model=Model(kind=kind)), vehicle.joints)
    return model, EquivalentState(model)


@pytest.fixture
def ticks(vehicle) -> list[dict[str, np.ndarray]]:
    """Returns random values of the input ports at some ticks."""
    rng = np.random.default_rng(0)
    sizes = {
        "base_setpoint": 9,
        "joint_setpoint": 3 * vehicle.joints,
        "disturbance": 6,
        "external_acceleration": 3,
    }
    return [
        {port: rng.normal(size=size) for port, size in sizes.items()}
        | {
            "state": vehicle.trim_state + 0.1 * rng.normal(size=len(vehicle.trim_state)),
            "specific_thrust": rng.normal(G, 1.0, size=1),
        }
        for _ in range(5)
    ]


def x_0(system, context, values) -> np.ndarray:
    for port, value in values.items():
        system.GetInputPort(port).FixValue(context, value)
    return system.GetOutputPort("x_0").Eval(context).copy()


def tick(system, context, values) -> np.ndarray:
    """Returns x_0 at a tick, and performs the update."""
    seen = x_0(system, context, values)
    context.SetDiscreteState(system.EvalUniquePeriodicDiscreteUpdate(context))
    return seen


def by_hand(model, values, last: np.ndarray | None) -> np.ndarray:
    """Returns x_0 from the layouts of the ports, with thrust by SciPy's rotations."""
    base, arm, n = values["base_setpoint"], values["joint_setpoint"], model.joints
    state = split_state(values["state"])
    axis = Rotation.from_quat(np.roll(state.quaternion, -1)).apply([0, 0, 1])
    thrust = values["specific_thrust"] * axis
    parts = {
        "p": state.p_B,
        "v": state.v_B,
        "p_d": base[:3],
        "v_d": base[3:6],
        "b": thrust - [0, 0, G],
        "r": np.cross(state.omega_W, thrust) * [1, 1, 0],
        "d": values["external_acceleration"],
        "h": values["disturbance"][:3],
    }
    x = np.zeros(len(model.A))
    for name, value in parts.items():
        x[model.base_state(name)] = value
    x[30::2], x[31::2] = arm[:n], arm[n : 2 * n]
    if last is not None:
        moved = model.predict(last, np.concatenate([base[6:], arm[2 * n :]]), np.zeros(3))
        for name in HIDDEN:
            x[model.base_state(name)] = moved[model.base_state(name)]
    return x


def test_ports_rate_and_feedthrough(vehicle):
    model, system = make(vehicle)
    sizes = {"state": 25, "base_setpoint": 9, "joint_setpoint": 18, "disturbance": 6}
    for port, size in (sizes | {"specific_thrust": 1, "external_acceleration": 3}).items():
        assert system.GetInputPort(port).size() == size
        assert system.HasDirectFeedthrough(system.GetInputPort(port).get_index(), 0)
    assert system.GetOutputPort("x_0").size() == len(model.A)
    timing = system.GetUniquePeriodicDiscreteUpdateAttribute()
    assert (timing.period_sec(), timing.offset_sec()) == (DT, 0)


def test_hidden_states_follow_the_model_from_tick_to_tick(vehicle, ticks):
    """All other states are measured or commanded; at the first tick, hidden states are zero."""
    model, system = make(vehicle)
    context, last = system.CreateDefaultContext(), None
    for values in ticks:
        x = tick(system, context, values)
        np.testing.assert_allclose(x, by_hand(model, values, last), rtol=0, atol=1e-10)
        last = x
    assert np.all(last[model.base_state("w")[:2]] != 0)


def test_measurements_between_ticks_have_no_effect(vehicle, ticks):
    model, system = make(vehicle)
    context = system.CreateDefaultContext()
    first = tick(system, context, ticks[0])
    x_0(system, context, ticks[1])
    expected = by_hand(model, ticks[2], first)
    np.testing.assert_allclose(tick(system, context, ticks[2]), expected, rtol=0, atol=1e-10)


@pytest.mark.parametrize(
    "port",
    [
        "state",
        "base_setpoint",
        "joint_setpoint",
        "disturbance",
        "external_acceleration",
        "specific_thrust",
    ],
)
def test_a_tick_with_nan_does_not_affect_later_ticks(vehicle, ticks, port):
    """The next tick is like the first."""
    _, system = make(vehicle)
    context = system.CreateDefaultContext()
    tick(system, context, ticks[0])
    broken = ticks[1] | {port: np.full_like(ticks[1][port], np.nan)}
    assert not np.isfinite(tick(system, context, broken)).all()
    again, fresh = (tick(system, c, ticks[2]) for c in (context, system.CreateDefaultContext()))
    assert np.isfinite(again).all()
    np.testing.assert_array_equal(again, fresh)


def test_contexts_are_independent(vehicle, ticks):
    model, system = make(vehicle)
    context = system.CreateDefaultContext()
    last = tick(system, context, ticks[0])
    clone = context.Clone()
    tick(system, context, ticks[1])
    x = tick(system, clone, ticks[2])
    np.testing.assert_allclose(x, by_hand(model, ticks[2], last), rtol=0, atol=1e-10)


def test_in_a_simulation_it_ticks_at_the_period_of_the_model(vehicle, ticks):
    """With constant inputs."""
    model, system = make(vehicle)
    simulator = Simulator(system)
    context = simulator.get_mutable_context()
    x_0(system, context, ticks[0])
    seen = None
    for k in range(1, 5):
        simulator.AdvanceTo(DT * (k - 0.5))
        expected = by_hand(model, ticks[0], seen)
        seen = context.get_discrete_state(0).value().copy()
        np.testing.assert_allclose(seen, expected, rtol=0, atol=1e-10)


def test_models_without_hidden_states_are_like_the_first_tick(vehicle, ticks):
    model, system = make(vehicle, "velocity_aware")
    context = system.CreateDefaultContext()
    tick(system, context, ticks[0])
    state, n = split_state(ticks[1]["state"]), vehicle.joints
    base, arm = ticks[1]["base_setpoint"], ticks[1]["joint_setpoint"]
    x = tick(system, context, ticks[1])
    expected = np.stack([state.p_B, state.v_B, base[:3], base[3:6]], axis=1).ravel()
    np.testing.assert_array_equal(x[:12], expected)
    np.testing.assert_array_equal(x[12:], np.stack([arm[:n], arm[n : 2 * n]], axis=1).ravel())
