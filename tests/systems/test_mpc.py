"""MpcSystem: ports, fallback and status; its prediction against the flown loop."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.common.value import Value

from aerodrake.flight.simulate import FlightSimulation
from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.model.mpc.formulation import MpcFormulation
from aerodrake.model.mpc.tick import MpcInputs
from aerodrake.model.qp.result import QpStatus
from aerodrake.model.vehicle.kinematics import Kinematics
from aerodrake.model.vehicle.state import split_state
from aerodrake.scenario import Flight, Lissajous, Model, Mpc
from aerodrake.support.tick_times import time_ticks
from aerodrake.systems.mpc import MpcSystem

N, DT = 6, 0.02
CONFIG = Mpc(
    horizon=N,
    k_e=(3.0, 2.5, 2.0),
    w_1=(1e4, 1.1e4, 0.9e4),
    w_2_base=(1e-3, 2e-3, 3e-3),
    w_2_joints=(1e-3,),
    w_3_base=(30.0, 40.0, 50.0),
    w_3_joints=(10.0,),
    w_4=(300.0, 200.0, 100.0),
    error="predicted",
    tilt="held",  # The prediction then depends on every input port.
)
WEIGHTS = [0.7, 1.0, 500.0, 20.0, 7.0]


@pytest.fixture(scope="module", params=[N, 20], ids=["stages of one tick", "longer stages"])
def formulation(vehicle, request) -> MpcFormulation:
    config = replace(CONFIG, span_ticks=request.param)
    model = EquivalentModel.make("exact", np.array([1.8, 2.0, 2.4]), DT, vehicle.joints)
    return MpcFormulation(config, model, vehicle)


@pytest.fixture(scope="module")
def kinematics(vehicle) -> Kinematics:
    return Kinematics(vehicle.plant)


@pytest.fixture
def mpc(formulation) -> MpcSystem:
    return MpcSystem(formulation)


def initial_state(state, base, arm) -> np.ndarray:
    """Returns x_0 (nx,), taken apart by the layouts of the ports."""
    n = len(arm) // 3
    x_0 = np.empty(12 + 2 * n)
    for i in range(3):
        x_0[4 * i : 4 * i + 4] = state[4 + i], state[7 + n + 3 + i], base[i], base[3 + i]
    x_0[12::2], x_0[13::2] = arm[:n], arm[n : 2 * n]
    return x_0


@pytest.fixture
def values(vehicle, kinematics):
    """Values of the input ports: near trim, and no two numbers equal."""
    rng = np.random.default_rng(0)
    state = vehicle.trim_state + 1e-2 * rng.normal(size=len(vehicle.trim_state))
    end_effector = kinematics.end_effector(split_state(state))
    horizon = 1e-2 * rng.normal(size=(N + 1, 6))
    horizon[:, :3] += end_effector.p_E
    n = vehicle.joints
    base = np.concatenate([vehicle.p_B, np.zeros(6)]) + 1e-2 * rng.normal(size=9)
    arm = np.concatenate([vehicle.working, np.zeros(2 * n)]) + 1e-2 * rng.normal(size=3 * n)
    return {
        "state": state,
        "end_effector": Value(end_effector),
        "x_0": initial_state(state, base, arm),
        "base_setpoint": base,
        "joint_setpoint": arm,
        "horizon": horizon.ravel(),
        "weights": np.array(WEIGHTS),
        "delta": 1e-2 * rng.normal(size=3),
    }


def tick(mpc, context, values) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Returns u, the prediction (N + 1, 3) and the status after an update."""
    for port, value in values.items():
        mpc.GetInputPort(port).FixValue(context, value)
    context.SetDiscreteState(mpc.EvalUniquePeriodicDiscreteUpdate(context))
    u, prediction, status = (
        mpc.GetOutputPort(port).Eval(context) for port in ("u", "prediction", "status")
    )
    return u, prediction.reshape(N + 1, 3), status


def plan(mpc, formulation, context) -> np.ndarray:
    """Returns the planned accelerations (T, 3 + n) at each tick of the horizon."""
    m = 3 + formulation.model.joints
    plan = mpc.GetOutputPort("plan").Eval(context).reshape(-1, m)
    assert len(plan) == sum(formulation.stage_ticks)
    return plan


def unconstrained(formulation, values) -> np.ndarray:
    """Returns the unconstrained optimum (N, 3 + n) for values taken from the ports."""
    rates = split_state(values["state"]).rpy_rates
    program = formulation.form(
        MpcInputs(
            x_0=values["x_0"],
            u_last=np.concatenate([values["base_setpoint"][6:], values["joint_setpoint"][12:]]),
            end_effector=values["end_effector"].get_value(),
            rpy_rates=rates,
            reference=values["horizon"].reshape(N + 1, 6),
            delta=values["delta"],
            w_q=WEIGHTS[2],
            w_m=WEIGHTS[3],
            w_d=WEIGHTS[4],
        )
    )
    z = np.linalg.solve(program.H, -program.g)
    assert np.abs(z).max() < 1  # Otherwise bounds would be active.
    return formulation.inputs(z)


def test_first_tick_is_the_unconstrained_optimum(mpc, formulation, values):
    context = mpc.CreateDefaultContext()
    u, _, status = tick(mpc, context, values)
    expected = np.repeat(unconstrained(formulation, values), formulation.stage_ticks, axis=0)
    np.testing.assert_allclose(plan(mpc, formulation, context), expected, rtol=1e-8, atol=1e-9)
    np.testing.assert_array_equal(u, plan(mpc, formulation, context)[0])
    assert tuple(status) == (QpStatus.UNCONSTRAINED, 0, 0)


def test_prediction_is_that_of_the_model_from_the_measured_end_effector(mpc, formulation, values):
    context = mpc.CreateDefaultContext()
    _, prediction, _ = tick(mpc, context, values)
    x_0, expected_plan = values["x_0"], unconstrained(formulation, values)
    end_effector, model = values["end_effector"].get_value(), formulation.model
    x, places = x_0, [0, 4, 8, *range(12, len(x_0), 2)]
    np.testing.assert_allclose(prediction[0], end_effector.p_E, atol=1e-14)
    for k in range(N):
        for _ in range(formulation.stage_ticks[k]):
            x = model.predict(x, expected_plan[k], values["delta"])
        moved = end_effector.J_s @ (x - x_0)[places]
        np.testing.assert_allclose(prediction[k + 1], end_effector.p_E + moved, atol=1e-10)


def test_has_no_direct_feedthrough(mpc):
    assert not mpc.HasAnyDirectFeedthrough()
    timing = mpc.GetUniquePeriodicDiscreteUpdateAttribute()
    assert (timing.period_sec(), timing.offset_sec()) == (DT, 0)


@pytest.mark.parametrize("port", ["state", "x_0", "base_setpoint", "horizon", "weights", "delta"])
def test_unsolved_programs_follow_the_shifted_plan(mpc, formulation, values, port):
    context = mpc.CreateDefaultContext()
    tick(mpc, context, values)
    first = plan(mpc, formulation, context).copy()

    broken = values | {port: np.full(len(values[port]), np.nan)}
    T = len(first)
    for k in range(1, T + 2):
        u, _, status = tick(mpc, context, broken)
        np.testing.assert_array_equal(u, first[k] if k < T else np.zeros_like(u))
        assert tuple(status) == (QpStatus.NON_FINITE, 0, k)

    # The next valid inputs are solved as if nothing had happened.
    u, prediction, status = tick(mpc, context, values)
    fresh, fresh_prediction, _ = tick(mpc, mpc.CreateDefaultContext(), values)
    assert tuple(status) == (QpStatus.UNCONSTRAINED, 0, 0)
    np.testing.assert_array_equal(u, fresh)
    np.testing.assert_array_equal(prediction, fresh_prediction)


def test_prediction_of_a_shifted_plan(mpc, formulation, values):
    """A stage of several ticks is predicted with the plan's input at its start."""
    context = mpc.CreateDefaultContext()
    tick(mpc, context, values)
    first = plan(mpc, formulation, context).copy()
    broken = values | {"weights": np.full(5, np.nan)}
    _, prediction, _ = tick(mpc, context, broken)
    shifted = np.vstack([first[1:], np.zeros_like(first[:1])])
    at, model, x = values["end_effector"].get_value(), formulation.model, values["x_0"]
    starts = np.cumsum([0, *formulation.stage_ticks[:-1]])
    for k, ticks in enumerate(formulation.stage_ticks):
        for _ in range(ticks):
            x = model.predict(x, shifted[starts[k]], values["delta"])
        moved = at.J_s @ (x - values["x_0"])[[0, 4, 8, *range(12, len(x), 2)]]
        np.testing.assert_allclose(prediction[k + 1], at.p_E + moved, atol=1e-10)


def test_a_target_out_of_reach_is_solved_within_bounds(mpc, formulation, values, vehicle):
    context = mpc.CreateDefaultContext()
    values["horizon"] = values["horizon"] + np.tile([5.0, -5.0, 5.0, 5.0, -5.0, 5.0], N + 1)
    u, prediction, status = tick(mpc, context, values)
    assert status[0] == QpStatus.SOLVED and status[1] > 0 and status[2] == 0
    limits = np.concatenate([CONFIG.base_acceleration_m_s2, vehicle.acceleration])
    assert np.all(np.abs(plan(mpc, formulation, context)) <= limits * (1 + 1e-9))
    assert np.any(np.abs(u) > 0.99 * limits)
    assert (prediction[-1] - prediction[0]) @ [1, -1, 1] > 0


def test_a_timer_does_not_feed_back(mpc, values):
    u, _, _ = tick(mpc, mpc.CreateDefaultContext(), values)
    times_ms = time_ticks(mpc)
    for count in (1, 2):
        again, _, _ = tick(mpc, mpc.CreateDefaultContext(), values)
        np.testing.assert_array_equal(u, again)
        assert len(times_ms) == count and min(times_ms) > 0


def test_stage_1_predicts_the_flown_loop(scenario):
    """To 10 % of the motion in 20 ms, with the gains and weights of a calm flight."""
    calm = replace(
        scenario,
        settle_s=0.1,
        duration=2.4,
        reference=Lissajous(amplitude_m=(0.2, 0.15, 0.1), period_s=(10.0, 8.0, 12.0), start_s=1.0),
        flight=Flight(
            interface="trajectory",
            position_gain=(9.0, 9.0, 9.0),
            velocity_gain=(5.0, 5.0, 5.0),
            integral_gain=(0.0, 0.0, 0.0),
            attitude_gain=(144.0, 144.0, 36.0),
            rate_gain=(24.0, 24.0, 12.0),
        ),
        model=Model(kind="velocity_aware", k_b=(1.8, 1.8, 1.8)),
        mpc=replace(
            CONFIG,
            horizon=15,
            k_e=(1.0, 1.0, 1.0),
            w_1=(1e3, 1e3, 1e3),
            w_2_base=(1e-3, 1e-3, 1e-3),
            w_3_base=(30.0, 30.0, 30.0),
            w_4=(300.0, 300.0, 300.0),
            tilt="none",
        ),
    )
    log = FlightSimulation(calm).fly()
    assert log.exit_reason == "completed"
    # Logs see the state before the update: the tick at sample i shows at i + 1.
    i = np.arange(150, 240, 2)
    now, later = log["p_E_m"][i], log["p_E_m"][i + 2]
    stages = log["predicted_p_E_m"][i + 1].reshape(len(i), -1, 3)
    np.testing.assert_allclose(stages[:, 0], now, atol=1e-12)
    distance = np.linalg.norm(later - now, axis=1)
    error = np.linalg.norm(stages[:, 1] - later, axis=1)
    assert distance.min() > 1e-3
    assert np.all(error < 0.1 * distance)
