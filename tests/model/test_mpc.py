"""The condensed MPC against the paper's problem, written with its states and solved by Clarabel."""

import dataclasses

import clarabel
import numpy as np
import pytest
from scipy import sparse
from scipy.optimize import linprog
from scipy.spatial.transform import Rotation

from aerodrake.model.equivalent_model import EquivalentModel
from aerodrake.model.horizon import stage_ticks
from aerodrake.model.mpc import MpcFormulation
from aerodrake.model.mpc_inputs import MpcInputs
from aerodrake.model.qp import CondensedQp, QpStatus
from aerodrake.model.setpoint import SetpointLimits
from aerodrake.model.tracking import tilt_matrix
from aerodrake.model.vehicle import Vehicle
from aerodrake.scenario import Model, Mpc, Scenario

K_B, DT = np.array([1.8, 2.5, 6.67]), 0.02
UP, G = np.array([0.0, 0.0, 1.0]), 9.81
OPTIONS = [
    # Model, e_E, roll and pitch, ticks of the horizon.
    ("flight", "frozen", "flatness", 20),
    ("velocity_aware", "predicted", "none", 15),
    ("velocity_aware", "frozen", "held", 25),
    ("integral", "predicted", "none", 15),
    ("integral", "frozen", "none", 15),
    ("paper", "predicted", "flatness", 15),
    ("exact", "frozen", "flatness", 30),
    ("exact", "predicted", "held", 15),
]


def make_model(kind: str, vehicle: Vehicle) -> EquivalentModel:
    return EquivalentModel.of(Scenario(model=Model(kind=kind, k_b=tuple(K_B))), vehicle.joints)


def formulation(
    config: Mpc, vehicle: Vehicle, kind: str, error: str, tilt: str, span: int
) -> MpcFormulation:
    """The formulation under test, with weights that tell all axes and joints apart."""
    config = dataclasses.replace(
        config,
        error=error,
        tilt=tilt,
        span_ticks=span,
        w_5=(3.0, 20.0, 150.0),
        k_e=(3.0, 2.0, 4.0),
        w_1=(1e4, 2e4, 0.5e4),
        w_2_base=(1e-2, 2e-2, 3e-2),
        w_2_joints=(1e-2, 2e-2, 1e-3, 3e-2, 2e-3, 1e-2),
        w_3_base=(30.0, 20.0, 40.0),
        w_3_joints=(10.0, 12.0, 8.0, 15.0, 9.0, 11.0),
        w_4=(300.0, 200.0, 400.0),
    )
    limits = SetpointLimits.make(config, vehicle)
    return MpcFormulation(config, make_model(kind, vehicle), limits, vehicle)


@pytest.fixture(scope="module")
def prepared(ticks_of):
    """The ticks with a residual; and with a commanded base where the model believes in it."""

    def prepared(model: EquivalentModel) -> list[MpcInputs]:
        made = []
        for k, tick in enumerate(ticks_of(model)):
            if model.believes_command:
                tick.x_0[[0, 1, 4, 5, 8, 9]] = tick.x_0[[2, 3, 6, 7, 10, 11]]
            delta = 0.05 * np.random.default_rng(k).normal(size=3)
            made.append(dataclasses.replace(tick, delta=delta))
        return made

    return prepared


def acceleration(model: EquivalentModel, x: np.ndarray) -> np.ndarray:
    """(3, ...), what tilts the base: b of the flight model, K_B (v_d - v) of the first-order ones.

    Args:
        x: (nx, ...).
    """
    if "b" in model.axis_states:
        return x[model.base_state("b")]
    return (K_B * (x[model.base_state("v_d")] - x[model.base_state("v")]).T).T


def displaced(r: np.ndarray, a: np.ndarray) -> np.ndarray:
    """(3, ...), by how much a horizontal acceleration's tilt moves the end-effector at `r`."""
    return np.cross(np.cross(UP, a.T) / G, r).T


class WrittenOut:
    """min of the stage costs over all states and inputs, dynamics as equalities.

    Variables are x_0 ... x_N, u_0 ... u_N-1; those of x in units of their size. With them
    the flight model's stages must not be long: its tilt forgets within a few ticks
    where it began, and the equalities hardly tell.
    """

    def __init__(self, config: Mpc, model: EquivalentModel, vehicle: Vehicle):
        self.config, self.model, self.vehicle = config, model, vehicle
        self.n, self.N = vehicle.joints, config.horizon
        self.nx, self.m = len(model.A), 3 + self.n
        self.size = (self.N + 1) * self.nx + self.N * self.m
        self.identity = np.eye(self.size)
        names = np.array(model.axis_states)
        units = np.select([names == "r", names == "alpha", names == "w"], [10.0, 300.0, 30.0], 1.0)
        self.units = np.concatenate([np.tile(units, 3), np.ones(2 * self.n)])

    def x(self, k: int) -> np.ndarray:
        """(nx, size), picks x_k."""
        return self.units[:, None] * self.identity[k * self.nx : (k + 1) * self.nx]

    def u(self, k: int) -> np.ndarray:
        """(3 + n, size), picks u_k."""
        first = (self.N + 1) * self.nx + k * self.m
        return self.identity[first : first + self.m]

    def stage(self, k: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """A, B and C over all ticks of a stage, by a power of the matrix that has all three."""
        model, nx = self.model, self.nx
        held = np.eye(nx + self.m + 3)
        held[:nx] = np.hstack([model.A, model.B, model.C])
        power = np.linalg.matrix_power(held, stage_ticks(self.config)[k])
        return np.split(power[:nx], [nx, nx + self.m], axis=1)

    def cost(self, tick: MpcInputs):
        """Yields (L, c, w): the cost is the sum of w |L z + c|^2."""
        config, model, at = self.config, self.model, tick.end_effector
        K_e, z0 = np.array(config.k_e), np.zeros(self.size)
        q_0 = tick.x_0[model.joint_position]

        def places(x: np.ndarray) -> np.ndarray:
            moved = x[model.base_position] + at.J_c[:, 4:] @ x[model.joint_position]
            if config.tilt == "flatness":
                moved = moved + displaced(at.r, acceleration(model, x))
            return moved

        for k, ticks in enumerate(stage_ticks(config), start=1):
            x, u = self.x(k), self.u(k - 1)
            v, qdot = x[model.base_velocity], x[model.joint_velocity]
            velocity, known = v + at.J_c[:, 4:] @ qdot, at.J_c[:, 3] * tick.rpy_rates[2]
            if config.tilt == "held":
                known = known + at.J_u @ tick.rpy_rates[:2]
            if config.tilt == "flatness":
                change = acceleration(model, x) - acceleration(model, self.x(k - 1))
                velocity = velocity + displaced(at.r, change / (ticks * DT))
            p_Ed, v_Ed = tick.reference[k, :3], tick.reference[k, 3:]
            if config.error == "predicted":
                e, e_fixed = places(x), at.p_E - places(tick.x_0) - p_Ed
            else:
                e, e_fixed = np.zeros((3, self.size)), at.p_E - tick.reference[0, :3]
            w_1, w_2, w_4 = (np.array(w) for w in (config.w_1, config.w_2_base, config.w_4))
            yield velocity + K_e[:, None] * e, known + K_e * e_fixed - v_Ed, ticks * w_1
            yield v, z0[:3], ticks * tick.w_q * w_2
            yield qdot, z0[: self.n], ticks * tick.w_m * np.array(config.w_2_joints)
            w_3 = ticks * np.concatenate([config.w_3_base, config.w_3_joints])
            yield u, z0[: self.m], w_3
            last, u_last = (self.u(k - 2)[:3], z0[:3]) if k > 1 else (0, -tick.u_last[:3])
            yield u[:3] - last, u_last, np.array(config.w_5)
            p_EB = at.p_EB - at.J_B @ q_0 - self.vehicle.p_O
            yield at.J_B @ x[model.joint_position], p_EB, ticks * tick.w_d * w_4

    def bounds(self):
        """Yields (G, h): G z <= h."""
        vehicle, config, model = self.vehicle, self.config, self.model
        for k in range(self.N):
            u, limit = self.u(k), [*config.base_acceleration_m_s2, *vehicle.acceleration]
            yield from ((u, limit), (-u, limit))
        for k in range(1, self.N + 1):
            x = self.x(k)
            v_d, q, qdot = (
                x[i] for i in (model.setpoint_velocity, model.joint_position, model.joint_velocity)
            )
            yield from ((v_d, config.base_velocity_m_s), (-v_d, config.base_velocity_m_s))
            yield from ((q, vehicle.upper), (-q, -vehicle.lower))
            yield from ((qdot, vehicle.velocity), (-qdot, vehicle.velocity))
        brake = q + (vehicle.velocity / (2 * vehicle.acceleration))[:, None] * qdot
        yield from ((brake, vehicle.upper), (-brake, -vehicle.lower))

    def solve(self, tick: MpcInputs) -> tuple[np.ndarray, float]:
        """(u_0, the share of input and state bounds that are active)."""
        L, c, w = (np.concatenate(parts) for parts in zip(*self.cost(tick), strict=True))
        L, w = sparse.csc_matrix(L), 1e-4 * w  # Of the size of the bounds' multipliers.
        P, linear = 2 * L.T @ sparse.diags(w) @ L, 2 * L.T @ (w * c)
        # Each row is divided by its unit as well.
        equal, equal_to = [self.x(0) / self.units[:, None]], [tick.x_0 / self.units]
        for k in range(self.N):
            A, B, C = self.stage(k)
            row = self.x(k + 1) - A @ self.x(k) - B @ self.u(k)
            equal.append(row / self.units[:, None])
            equal_to.append(C @ tick.delta / self.units)
        G, h = (np.concatenate(parts) for parts in zip(*self.bounds(), strict=True))
        settings = clarabel.DefaultSettings()
        settings.verbose = False
        settings.tol_gap_abs = settings.tol_gap_rel = 1e-13
        settings.tol_feas = 1e-10
        settings.iterative_refinement_max_iter = 100
        cones = [clarabel.ZeroConeT(self.nx * (self.N + 1)), clarabel.NonnegativeConeT(len(h))]
        solution = clarabel.DefaultSolver(
            sparse.triu(P, format="csc"),
            linear,
            sparse.csc_matrix(np.vstack([*equal, G])),
            np.concatenate([*equal_to, h]),
            cones,
            settings,
        ).solve()
        solved = clarabel.SolverStatus.Solved, clarabel.SolverStatus.AlmostSolved
        assert solution.status in solved
        z = np.array(solution.x)
        self.is_exact = solution.status == clarabel.SolverStatus.Solved
        self.U = np.array([self.u(k) @ z for k in range(self.N)])
        return self.u(0) @ z, float(np.mean(h - G @ z < 1e-4))


@pytest.mark.parametrize("option", OPTIONS)
def test_optimum_is_that_of_the_problem_written_out(option, prepared, tight_scenario, vehicle):
    """At every eighth tick of a flight along its bounds: over 100 programs in all."""
    ours = formulation(tight_scenario.mpc, vehicle, *option)
    qp = CondensedQp(ours.A, ours.config.max_iterations)
    theirs = WrittenOut(ours.config, ours.model, vehicle)
    statuses, active, gaps = [], [], []
    for tick in prepared(ours.model)[::8]:
        program = ours.form(tick)
        result = qp.solve(program.H, program.g, program.lower, program.upper)
        u_0, share = theirs.solve(tick)
        statuses.append(result.status)
        active.append(share)
        gaps.append(np.abs(ours.inputs(result.z)[0] - u_0).max())
        if not theirs.is_exact:  # Then it is off, not we: ours is feasible, and cheaper.
            costs = [
                z @ program.H @ z / 2 + program.g @ z
                for z in (result.z, theirs.U.T.ravel() / ours.scale)
            ]
            assert costs[0] <= costs[1] + 1e-9
            assert np.all(ours.A @ result.z <= program.upper + 1e-9)
            assert np.all(ours.A @ result.z >= program.lower - 1e-9)
            gaps.pop()
    assert len(OPTIONS) * len(statuses) > 100 and len(gaps) > len(statuses) / 2
    assert np.max(gaps) < 1e-5
    assert set(statuses) <= {QpStatus.UNCONSTRAINED, QpStatus.EXCHANGED, QpStatus.SOLVED}
    assert np.mean(np.array(active) > 0) > 0.5


@pytest.mark.parametrize("option", OPTIONS[:3])
def test_prediction_of_the_program_is_the_models(option, prepared, tight_scenario, vehicle):
    """Of all stages, and of p_E by J_s and tilt from where it is."""
    ours = formulation(tight_scenario.mpc, vehicle, *option)
    model, tick = ours.model, prepared(ours.model)[50]
    u = np.random.default_rng(0).normal(size=(ours.config.horizon, 3 + vehicle.joints))
    free = driven = tick.x_0
    program, at = ours.form(tick), tick.end_effector
    p_E = ours.predict(tick, program, u)
    for k, ticks in enumerate(ours.stage_ticks):
        for _ in range(ticks):
            free = model.predict(free, np.zeros_like(u[k]), tick.delta)
            driven = model.predict(driven, u[k], tick.delta)
        places = [*model.base_position, *model.joint_position]
        m = len(places)
        np.testing.assert_allclose(
            program.free[m : 2 * m, k], (free - tick.x_0)[places], atol=1e-12
        )
        moved = driven - tick.x_0
        place = moved[model.base_position] + at.J_c[:, 4:] @ moved[model.joint_position]
        if ours.config.tilt == "flatness":
            place = place + displaced(at.r, acceleration(model, moved))
        np.testing.assert_allclose(p_E[k + 1], at.p_E + place, atol=1e-10)
    np.testing.assert_array_equal(p_E[0], at.p_E)


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
    model, limits = make_model("flight", vehicle), SetpointLimits.make(config, vehicle)
    for name in ("H", "g"):
        one, other = (
            getattr(MpcFormulation(c, model, limits, vehicle).form(ticks[0]), name)
            for c in (config, spelled_out)
        )
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("horizon", [10, 15])
def test_a_feasible_program_is_followed_by_a_feasible_one(horizon, ticks_of, vehicle):
    """Flown by plans that care for nothing but speed towards the joints' upper limits.

    The horizons are those in which a joint can stop: v_max / a_max = 10 ticks and more.
    """
    config, model = Mpc(horizon=horizon, span_ticks=horizon), make_model("velocity_aware", vehicle)
    ours = MpcFormulation(config, model, SetpointLimits.make(config, vehicle), vehicle)
    first = ticks_of(model)[0]
    tick = dataclasses.replace(first, reference=np.zeros((horizon + 1, 6)), delta=np.zeros(3))
    by_input = ours.prediction.Gamma[:, model.joint_velocity].sum(axis=(0, 1))
    speeds = by_input.reshape(horizon, -1).T.ravel() * ours.scale
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
        x = model.predict(x, ours.inputs(plan.x)[0], tick.delta)
    to_limit = vehicle.upper - x[model.joint_position]
    assert np.all(to_limit >= -1e-6) and np.all(to_limit < 0.2)
