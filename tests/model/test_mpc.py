"""The condensed MPC against the paper's problem, written with its states and solved by Clarabel."""

import dataclasses

import clarabel
import numpy as np
import pytest
from scipy import sparse
from scipy.optimize import linprog
from scipy.spatial.transform import Rotation

from aerodrake.model.equivalent_model import EquivalentModel
from aerodrake.model.mpc import MpcFormulation, MpcInputs, tilt_matrix
from aerodrake.model.qp import CondensedQp, QpStatus
from aerodrake.model.setpoint import SetpointLimits
from aerodrake.model.vehicle import Vehicle
from aerodrake.scenario import Mpc

K_B, DT = np.array([1.8, 2.5, 6.67]), 0.02
UP, G = np.array([0.0, 0.0, 1.0]), 9.81
OPTIONS = [
    # Model, e_E, roll and pitch.
    ("velocity_aware", "predicted", "none"),
    ("velocity_aware", "frozen", "held"),
    ("integral", "predicted", "none"),
    ("integral", "frozen", "none"),
    ("paper", "predicted", "flatness"),
    ("exact", "frozen", "flatness"),
    ("exact", "predicted", "held"),
]


def formulation(config: Mpc, vehicle: Vehicle, kind: str, error: str, tilt: str) -> MpcFormulation:
    """The formulation under test, with weights that tell all axes and joints apart."""
    config = dataclasses.replace(
        config,
        error=error,
        tilt=tilt,
        k_e=(3.0, 2.0, 4.0),
        w_1=(1e4, 2e4, 0.5e4),
        w_2_base=(1e-2, 2e-2, 3e-2),
        w_2_joints=(1e-2, 2e-2, 1e-3, 3e-2, 2e-3, 1e-2),
        w_3_base=(30.0, 20.0, 40.0),
        w_3_joints=(10.0, 12.0, 8.0, 15.0, 9.0, 11.0),
        w_4=(300.0, 200.0, 400.0),
    )
    model = EquivalentModel.make(kind, K_B, DT, vehicle.joints)
    return MpcFormulation(config, model, SetpointLimits.make(config, vehicle), vehicle)


def prepared(tick: MpcInputs, kind: str, k: int) -> MpcInputs:
    """The k-th tick with a residual; and with a commanded base where the model believes in it."""
    x_0 = tick.x_0.copy()
    if kind == "integral":
        x_0[[0, 1, 4, 5, 8, 9]] = x_0[[2, 3, 6, 7, 10, 11]]
    delta = 0.05 * np.random.default_rng(k).normal(size=3)
    return dataclasses.replace(tick, x_0=x_0, delta=delta)


class WrittenOut:
    """min of the stage costs over all states and inputs, dynamics as equalities.

    Variables are x_0 ... x_N, u_0 ... u_N-1, with x laid out as in the paper.
    """

    def __init__(self, config: Mpc, model: EquivalentModel, vehicle: Vehicle):
        self.config, self.model, self.vehicle = config, model, vehicle
        self.n, self.N = vehicle.joints, config.horizon
        self.nx, self.m = 12 + 2 * self.n, 3 + self.n
        self.size = (self.N + 1) * self.nx + self.N * self.m
        self.identity = np.eye(self.size)

    def x(self, k: int) -> np.ndarray:
        """(nx, size), picks x_k."""
        return self.identity[k * self.nx : (k + 1) * self.nx]

    def u(self, k: int) -> np.ndarray:
        """(3 + n, size), picks u_k."""
        first = (self.N + 1) * self.nx + k * self.m
        return self.identity[first : first + self.m]

    def cost(self, tick: MpcInputs):
        """Yields (L, c, w): the cost is the sum of w |L z + c|^2."""
        config, at, z0 = self.config, tick.end_effector, np.zeros(self.size)
        K_e = np.array(config.k_e)
        p_0, q_0 = tick.x_0[0:12:4], tick.x_0[12::2]
        a_0 = K_B * (tick.x_0[3:12:4] - tick.x_0[1:12:4])

        def displaced(a: np.ndarray) -> np.ndarray:
            """By how much a horizontal acceleration's tilt moves the end-effector."""
            return np.cross(np.cross(UP, a.T) / G, at.r).T

        for k in range(1, self.N + 1):
            x, u = self.x(k), self.u(k - 1)
            p, v, v_d, q, qdot = x[0:12:4], x[1:12:4], x[3:12:4], x[12::2], x[13::2]
            a = K_B[:, None] * (v_d - v)
            velocity = v + at.J_c[:, 4:] @ qdot
            known = at.J_c[:, 3] * tick.yaw_rate
            moved = p + at.J_c[:, 4:] @ q
            moved_0 = p_0 + at.J_c[:, 4:] @ q_0
            if config.tilt == "held":
                known = known + at.J_u @ tick.xi_u_rates
            if config.tilt == "flatness":
                velocity = velocity + displaced(K_B[:, None] * (u[:3] - a))
                moved = moved + displaced(a)
                moved_0 = moved_0 + displaced(a_0)
            p_Ed, v_Ed = tick.reference[k, :3], tick.reference[k, 3:]
            if config.error == "predicted":
                e, e_fixed = moved, at.p_E - moved_0 - p_Ed
            else:
                e, e_fixed = np.zeros((3, self.size)), at.p_E - tick.reference[0, :3]
            yield velocity + K_e[:, None] * e, known + K_e * e_fixed - v_Ed, config.w_1
            yield v, z0[:3], tick.w_q * np.array(config.w_2_base)
            yield qdot, z0[: self.n], tick.w_m * np.array(config.w_2_joints)
            yield u, z0[: self.m], np.concatenate([config.w_3_base, config.w_3_joints])
            p_EB = at.p_EB - at.J_B @ q_0 - self.vehicle.p_O
            yield at.J_B @ q, p_EB, tick.w_d * np.array(config.w_4)

    def bounds(self):
        """Yields (G, h): G z <= h."""
        vehicle, config = self.vehicle, self.config
        for k in range(self.N):
            u, limit = self.u(k), [*config.base_acceleration_m_s2, *vehicle.acceleration]
            yield from ((u, limit), (-u, limit))
        for k in range(1, self.N + 1):
            v_d, q, qdot = self.x(k)[3:12:4], self.x(k)[12::2], self.x(k)[13::2]
            yield from ((v_d, config.base_velocity_m_s), (-v_d, config.base_velocity_m_s))
            yield from ((q, vehicle.upper), (-q, -vehicle.lower))
            yield from ((qdot, vehicle.velocity), (-qdot, vehicle.velocity))
        brake = q + (vehicle.velocity / (2 * vehicle.acceleration))[:, None] * qdot
        yield from ((brake, vehicle.upper), (-brake, -vehicle.lower))

    def solve(self, tick: MpcInputs) -> tuple[np.ndarray, float]:
        """(u_0, the share of input and state bounds that are active)."""
        model = self.model
        L, c, w = (np.concatenate(parts) for parts in zip(*self.cost(tick), strict=True))
        L = sparse.csc_matrix(L)
        P, linear = 2 * L.T @ sparse.diags(w) @ L, 2 * L.T @ (w * c)
        equal = [self.x(0)] + [
            self.x(k + 1) - model.A @ self.x(k) - model.B @ self.u(k) for k in range(self.N)
        ]
        equal_to = [tick.x_0] + [model.C @ tick.delta] * self.N
        G, h = (np.concatenate(parts) for parts in zip(*self.bounds(), strict=True))
        settings = clarabel.DefaultSettings()
        settings.verbose = False
        settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = 1e-11
        cones = [clarabel.ZeroConeT(self.nx * (self.N + 1)), clarabel.NonnegativeConeT(len(h))]
        solution = clarabel.DefaultSolver(
            sparse.triu(P, format="csc"),
            linear,
            sparse.csc_matrix(np.vstack([*equal, G])),
            np.concatenate([*equal_to, h]),
            cones,
            settings,
        ).solve()
        assert solution.status == clarabel.SolverStatus.Solved
        z = np.array(solution.x)
        return self.u(0) @ z, float(np.mean(h - G @ z < 1e-4))


@pytest.mark.parametrize(("kind", "error", "tilt"), OPTIONS)
def test_optimum_is_that_of_the_problem_written_out(
    kind, error, tilt, ticks, tight_scenario, vehicle
):
    """At every eighth tick of a flight along its bounds: over 100 programs in all."""
    ours = formulation(tight_scenario.mpc, vehicle, kind, error, tilt)
    qp = CondensedQp(ours.A, ours.config.max_iterations)
    theirs = WrittenOut(ours.config, ours.model, vehicle)
    statuses, active, gaps = [], [], []
    for k, tick in list(enumerate(ticks))[::8]:
        tick = prepared(tick, kind, k)
        program = ours.form(tick)
        result = qp.solve(program.H, program.g, program.lower, program.upper)
        u_0, share = theirs.solve(tick)
        statuses.append(result.status)
        active.append(share)
        gaps.append(np.abs((ours.scale * result.z)[: len(u_0)] - u_0).max())
    assert len(OPTIONS) * len(gaps) > 100
    assert np.max(gaps) < 1e-3 and np.median(gaps) < 1e-5
    assert set(statuses) <= {QpStatus.UNCONSTRAINED, QpStatus.SOLVED}
    assert np.mean(np.array(active) > 0) > 0.5


def test_prediction_of_the_program_is_the_models(ticks, tight_scenario, vehicle):
    ours = formulation(tight_scenario.mpc, vehicle, *OPTIONS[0])
    tick = prepared(ticks[50], "velocity_aware", 50)
    x = tick.x_0
    for predicted in ours.form(tick).x_free:
        x = ours.model.predict(x, np.zeros(3 + vehicle.joints), tick.delta)
        np.testing.assert_allclose(predicted, x, atol=1e-12)


def test_tilt_matrix_is_the_rotation_of_the_thrust_axis():
    """Turned so that the thrust points along g + a, the base moves its tool by T a."""
    r = np.array([0.1, 0.2, -0.3])
    for a in 0.01 * np.vstack([np.eye(3), [1, -2, 0.5]]):
        thrust = a + G * UP
        turned = Rotation.align_vectors(thrust[None], UP[None])[0]
        np.testing.assert_allclose(tilt_matrix(r) @ a, turned.apply(r) - r, atol=2e-6)


def test_per_joint_weights_may_be_given_once(tight_scenario, ticks, vehicle):
    config = tight_scenario.mpc
    spelled_out = dataclasses.replace(
        config, w_2_joints=config.w_2_joints * 6, w_3_joints=config.w_3_joints * 6
    )
    model = EquivalentModel.make("velocity_aware", K_B, DT, vehicle.joints)
    limits = SetpointLimits.make(config, vehicle)
    for name in ("H", "g"):
        one, other = (
            getattr(MpcFormulation(c, model, limits, vehicle).form(ticks[0]), name)
            for c in (config, spelled_out)
        )
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("horizon", [10, 15])
def test_a_feasible_program_is_followed_by_a_feasible_one(horizon, ticks, vehicle):
    """Flown by plans that care for nothing but speed towards the joints' upper limits.

    The horizons are those in which a joint can stop: v_max / a_max = 10 ticks and more.
    """
    config = Mpc(horizon=horizon)
    model = EquivalentModel.make("velocity_aware", K_B, DT, vehicle.joints)
    ours = MpcFormulation(config, model, SetpointLimits.make(config, vehicle), vehicle)
    tick = dataclasses.replace(ticks[0], reference=np.zeros((horizon + 1, 6)), delta=np.zeros(3))
    speeds = ours.prediction.Gamma[:, model.joint_velocity].sum(axis=(0, 1)) * ours.scale
    x = tick.x_0.copy()
    x[model.joint_position] = vehicle.upper - 0.8
    for k in range(35):
        program = ours.form(dataclasses.replace(tick, x_0=x))
        plan = linprog(
            -speeds,
            A_ub=np.vstack([ours.A, -ours.A]),
            b_ub=np.concatenate([program.upper, -program.lower]) + 1e-9,
            bounds=(-1, 1),
        )
        assert plan.status == 0, f"infeasible at tick {k}"
        x = model.predict(x, (ours.scale * plan.x)[: 3 + vehicle.joints], tick.delta)
    to_limit = vehicle.upper - x[model.joint_position]
    assert np.all(to_limit >= -1e-6) and np.all(to_limit < 0.2)
