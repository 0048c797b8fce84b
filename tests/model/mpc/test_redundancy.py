"""DecoupledMinimiser against the minimiser of the whole program."""

import dataclasses

import numpy as np
import pytest

from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.model.mpc.formulation import MpcFormulation
from aerodrake.model.mpc.redundancy import DecoupledMinimiser, task_basis
from aerodrake.model.mpc.solver import MpcSolver
from aerodrake.model.mpc.tick import MpcInputs, Pointing
from aerodrake.model.qp.condensed_qp import CondensedQp, QpStatus
from aerodrake.model.vehicle.kinematics import Kinematics
from aerodrake.model.vehicle.state import split_state
from aerodrake.scenario import Mpc, Scenario

CONFIG = Mpc(horizon=7, span_ticks=20, w_6=70.0, k_o=4.0)


def formulation(vehicle, **changes) -> MpcFormulation:
    config = dataclasses.replace(CONFIG, **changes)
    model = EquivalentModel.of(Scenario(), vehicle.joints)
    return MpcFormulation(config, model, vehicle)


def make_tick(vehicle, model, pointing: bool, seed: int = 0) -> MpcInputs:
    rng = np.random.default_rng(seed)
    kinematics = Kinematics(vehicle.plant)
    x = vehicle.trim_state + 0.1 * rng.normal(size=len(vehicle.trim_state))
    state = split_state(x)
    axis = kinematics.tool_axis(state)
    d = axis.value + 0.05 * rng.normal(size=(CONFIG.horizon + 1, 3))
    return MpcInputs(
        x_0=0.05 * rng.normal(size=len(model.A)),
        u_last=rng.normal(size=3 + vehicle.joints),
        end_effector=kinematics.end_effector(state),
        rpy_rates=0.05 * rng.normal(size=3),
        reference=0.1 * rng.normal(size=(CONFIG.horizon + 1, 6)),
        delta=0.01 * rng.normal(size=3),
        w_q=300.0,
        w_m=20.0,
        w_d=5.0,
        pointing=Pointing(axis, np.hstack([d, 0 * d])) if pointing else None,
    )


def minimiser(ours: MpcFormulation, program) -> np.ndarray | None:
    return DecoupledMinimiser(ours.condensing, ours.W_2).minimiser(
        program.C, program.g, program.task_jacobian
    )


@pytest.mark.parametrize("pointing", [False, True])
@pytest.mark.parametrize("tilt", ["flatness", "held"])
def test_equals_the_minimiser_of_the_whole_program(vehicle, pointing, tilt):
    ours = formulation(vehicle, tilt=tilt)
    for seed in range(5):
        program = ours.form(make_tick(vehicle, ours.model, pointing, seed))
        best = -np.linalg.solve(program.H, program.g)
        np.testing.assert_allclose(minimiser(ours, program), best, atol=1e-9 * np.abs(best).max())


@pytest.mark.parametrize(
    "changes",
    [
        {"w_2_joints": (1.0, 1.0, 1.0, 1.0, 1.0, 1.1)},
        {"w_3_joints": (3.0, 3.0, 4.0, 3.0, 3.0, 3.0)},
    ],
)
def test_different_joint_weights_do_not_decouple(vehicle, changes):
    ours = formulation(vehicle, **changes)
    assert minimiser(ours, ours.form(make_tick(vehicle, ours.model, pointing=False))) is None


def test_a_singular_arm_has_a_larger_null_space(vehicle):
    ours = formulation(vehicle)
    tick = make_tick(vehicle, ours.model, pointing=False)
    at = tick.end_effector
    flat = np.diag([1.0, 1.0, 0.0])  # The joints cannot move the tool along z.
    J_c = at.J_c.copy()
    J_c[:, 4:] = flat @ at.J_B
    at = dataclasses.replace(at, J_B=flat @ at.J_B, J_c=J_c)
    program = ours.form(dataclasses.replace(tick, end_effector=at))
    assert task_basis(program.task_jacobian)[1] == 2
    best = -np.linalg.solve(program.H, program.g)
    np.testing.assert_allclose(minimiser(ours, program), best, atol=1e-9 * np.abs(best).max())


@pytest.mark.parametrize(("rows", "rank"), [(0, 0), (1, 1), (3, 3), (4, 3), (6, 6), (8, 6)])
def test_task_basis_is_orthonormal_and_spans_the_row_space_first(rows, rank):
    rng = np.random.default_rng(rows)
    task_jacobian = rng.normal(size=(rows, 6))
    if rows == 4:
        task_jacobian[2] = task_jacobian[0] - 2 * task_jacobian[1]
    Q, r = task_basis(task_jacobian)
    assert r == rank
    np.testing.assert_allclose(Q.T @ Q, np.eye(6), atol=1e-12)
    np.testing.assert_allclose(task_jacobian @ Q[:, r:], 0, atol=1e-10)


def test_the_solver_uses_it_if_no_bound_is_active(vehicle):
    """With and without active bounds and guess, the solution is that of the whole program."""
    ours = formulation(vehicle)
    solver, whole = MpcSolver(ours), CondensedQp(ours.A, ours.config.max_iterations)
    statuses = set()
    for seed in range(6):
        program = ours.form(make_tick(vehicle, ours.model, pointing=False, seed=seed))
        for scale in (1e-3, 1e3):
            program = dataclasses.replace(program, g=scale * program.g)
            expected = whole.solve(program.H, program.g, program.lower, program.upper)
            for active in (None, expected.active):
                result = solver.solve(program, active)
                assert result.status is expected.status
                np.testing.assert_allclose(result.z, expected.z, atol=1e-8)
            statuses.add(result.status)
    assert statuses == {QpStatus.UNCONSTRAINED, QpStatus.EXCHANGED}
