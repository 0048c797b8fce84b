"""FaultyMpc: times, kinds and severity of MPC faults, and the ticks that they affect."""

import numpy as np
import pytest

from aerodrake.model.equivalent.initial_state import Signals
from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.model.mpc.custom_terms import CustomConstraint
from aerodrake.model.mpc.formulation import MpcFormulation
from aerodrake.model.mpc.tick import MISSED, MpcInputs, TickStatus
from aerodrake.model.qp.result import QpStatus
from aerodrake.model.vehicle.kinematics import Kinematics
from aerodrake.model.vehicle.state import split_state
from aerodrake.scenario import (
    Mpc,
    MpcInfeasible,
    MpcMissed,
    MpcNonFinite,
    MpcStarved,
    Push,
)
from aerodrake.support.tick_times import time_ticks
from aerodrake.systems.faults.mpc import FaultyMpc, make_mpc
from aerodrake.systems.mpc import MpcSystem

SETTLE_S = 3.0


CONFIG = Mpc(horizon=6, w_3_base=(30.0, 30.0, 30.0))


@pytest.fixture(scope="module")
def formulation(vehicle) -> MpcFormulation:
    model = EquivalentModel.make("velocity_aware", np.ones(3), 0.02, vehicle.joints)
    return MpcFormulation(CONFIG, model, vehicle)


@pytest.fixture(scope="module")
def inputs(vehicle, formulation) -> MpcInputs:
    """Inputs of a tick at rest in trim, 5 m from the target: constraints are active."""
    state, n = vehicle.trim_state, vehicle.joints
    end_effector = Kinematics(vehicle.plant).end_effector(split_state(state))
    base = np.concatenate([vehicle.p_B, np.zeros(6)])
    arm = np.concatenate([vehicle.working, np.zeros(2 * n)])
    target = np.concatenate([end_effector.p_E + [5.0, 0.0, 0.0], np.zeros(3)])
    return MpcInputs(
        x_0=formulation.model.initial_state(Signals(state[4:7], np.zeros(3), base, arm)),
        u_last=np.zeros(3 + n),
        end_effector=end_effector,
        rpy_rates=np.zeros(3),
        reference=np.tile(target, (CONFIG.horizon + 1, 1)),
        delta=np.zeros(3),
        w_q=500.0,
        w_m=20.0,
        w_d=7.0,
    )


def at(mpc, time: float):
    """A Context at a reference time."""
    context = mpc.CreateDefaultContext()
    context.SetTime(SETTLE_S + time)
    return context


def solve(formulation, inputs, *faults):
    """Returns the program and the result of one tick at reference time 5.5 s."""
    mpc = FaultyMpc(formulation, faults, SETTLE_S)
    return mpc.solve_tick(at(mpc, 5.5), inputs)


def test_a_fault_acts_from_its_start_until_before_its_end(formulation):
    missed = MpcMissed(start_s=0.1, duration_s=0.2)
    mpc = FaultyMpc(formulation, [Push(), missed], SETTLE_S)
    for time, fault in ((0.0, None), (0.1, missed), (0.29, missed), (0.3, None), (1.0, None)):
        assert mpc.active_fault(at(mpc, time)) is fault


def test_the_most_severe_fault_acts_and_the_fewest_iterations(formulation):
    infeasible, starved = MpcInfeasible(duration_s=0.5), MpcStarved(iterations=2)
    faults = [MpcStarved(iterations=9), starved, infeasible]
    mpc = FaultyMpc(formulation, faults, SETTLE_S)
    assert mpc.active_fault(at(mpc, 5.2)) is infeasible
    assert mpc.active_fault(at(mpc, 5.7)) is starved
    assert mpc.active_fault(at(mpc, 9.0)) is None
    kinds = [MpcMissed(), MpcNonFinite(), infeasible, starved]
    for i, fault in enumerate(kinds):
        assert FaultyMpc(formulation, kinds[i:], SETTLE_S).active_fault(at(mpc, 5.2)) is fault


@pytest.mark.parametrize(
    ("faults", "status"),
    [
        ((), QpStatus.SOLVED),
        ((MpcInfeasible(),), QpStatus.INFEASIBLE),
        ((MpcNonFinite(),), QpStatus.NON_FINITE),
        ((MpcStarved(iterations=1),), QpStatus.ITERATION_LIMIT),
    ],
)
def test_faulty_programs_are_not_solved(formulation, inputs, faults, status):
    program, result = solve(formulation, inputs, *faults)
    assert result.status is status
    # The fault is in the solver alone: predictions are those of the true program.
    np.testing.assert_array_equal(program.lower, formulation.form(inputs).lower)
    np.testing.assert_array_equal(program.g, formulation.form(inputs).g)


def test_a_starved_solver_returns_the_iterate_of_osqp(formulation, inputs):
    program, result = solve(formulation, inputs)

    def cost(z: np.ndarray) -> float:
        return z @ program.H @ z / 2 + program.g @ z

    best = cost(result.z)
    _, near = solve(formulation, inputs, MpcStarved(iterations=500))
    assert near.status is QpStatus.INACCURATE and near.iterations > 0
    assert best < cost(near.z) < best + 0.02 * abs(best)


class OneTick(FaultyMpc):
    """A faulty MPC whose inputs do not come from ports."""

    def __init__(self, formulation, faults, inputs):
        super().__init__(formulation, faults, SETTLE_S)
        self._inputs = inputs

    def tick_inputs(self, context):
        return self._inputs


@pytest.mark.parametrize(
    ("fault", "status"),
    [
        (None, QpStatus.SOLVED),
        (MpcStarved(iterations=1), QpStatus.ITERATION_LIMIT),
        (MpcInfeasible(), QpStatus.INFEASIBLE),
        (MpcNonFinite(), QpStatus.NON_FINITE),
        (MpcMissed(), MISSED),
    ],
)
def test_a_tick_with_a_fault_follows_the_shifted_plan(formulation, inputs, fault, status):
    """And reports its status; a missed tick solves nothing, so it is not timed."""
    mpc = OneTick(formulation, [fault] if fault else [], inputs)
    times_ms = time_ticks(mpc)
    context = at(mpc, 0.0)
    mpc.GetInputPort("weights").FixValue(context, np.zeros(5))
    mpc.GetInputPort("delta").FixValue(context, np.zeros(3))
    context.SetDiscreteState(mpc.EvalUniquePeriodicDiscreteUpdate(context))
    first = mpc.GetOutputPort("plan").Eval(context).reshape(-1, len(inputs.u_last)).copy()
    assert first.any() and len(times_ms) == 1
    context.SetTime(SETTLE_S + 5.5)
    context.SetDiscreteState(mpc.EvalUniquePeriodicDiscreteUpdate(context))
    reported = TickStatus(*mpc.GetOutputPort("status").Eval(context))
    assert reported.status == status
    assert reported.ticks_since_solved == (fault is not None)
    u = mpc.GetOutputPort("u").Eval(context)
    np.testing.assert_array_equal(u, first[1] if fault else first[0])
    assert len(times_ms) == 1 + (status != MISSED)


def test_only_a_scenario_with_mpc_faults_has_a_faulty_mpc(formulation):
    assert type(make_mpc(formulation, (), SETTLE_S)) is MpcSystem
    assert type(make_mpc(formulation, (Push(),), SETTLE_S)) is MpcSystem
    assert type(make_mpc(formulation, (Push(), MpcMissed()), SETTLE_S)) is FaultyMpc


def test_missed_is_not_a_status_of_a_program():
    assert max(QpStatus) < MISSED


def test_an_extended_mpc_keeps_its_faults(formulation):
    faults = [MpcMissed(start_s=1.0, duration_s=1.0)]
    bound = CustomConstraint(quantity="base_velocity", name="slow", upper=0.5)
    mpc = make_mpc(formulation, faults, SETTLE_S).extended(bound)
    assert mpc.active_fault(at(mpc, 1.5)) == faults[0] and mpc.active_fault(at(mpc, 2.5)) is None
    assert mpc.formulation.custom.terms == (bound,) and not formulation.custom.terms
    assert type(MpcSystem(formulation).extended(bound)) is MpcSystem
