"""The paper's MPC problem with explicit states, the dynamics as equality constraints."""

import clarabel
import numpy as np
from scipy import sparse

from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.model.mpc.horizon import stage_ticks
from aerodrake.model.mpc.tick import MpcInputs
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Mpc

K_B, DT = np.array([1.8, 2.5, 6.67]), 0.02
UP, G = np.array([0.0, 0.0, 1.0]), 9.81


def acceleration(model: EquivalentModel, x: np.ndarray) -> np.ndarray:
    """Returns (3, ...): b of the flight model, K_B (v_d - v) of the first-order models.

    Args:
        x: (nx, ...).
    """
    if "b" in model.axis_states:
        return x[model.base_state("b")]
    return (K_B * (x[model.base_state("v_d")] - x[model.base_state("v")]).T).T


def displacement(r: np.ndarray, a: np.ndarray) -> np.ndarray:
    """Returns the displacement (3, ...) of the end-effector at `r` by a horizontal acceleration."""
    return np.cross(np.cross(UP, a.T) / G, r).T


class ExplicitMpc:
    """Minimises the stage costs over all states and inputs, subject to the dynamics.

    Variables are x_0 ... x_N, u_0 ... u_N-1, with x scaled. Stages of the flight model must
    be short: its tilt decays within a few ticks, which makes the equalities ill-conditioned.
    """

    def __init__(self, config: Mpc, model: EquivalentModel, vehicle: VehicleModel):
        self.config, self.model, self.vehicle = config, model, vehicle
        self.n, self.N = vehicle.joints, config.horizon
        self.nx, self.m = len(model.A), 3 + self.n
        self.size = (self.N + 1) * self.nx + self.N * self.m
        self.identity = np.eye(self.size)
        names = np.array(model.axis_states)
        units = np.select([names == "r", names == "alpha", names == "w"], [10.0, 300.0, 30.0], 1.0)
        self.units = np.concatenate([np.tile(units, 3), np.ones(2 * self.n)])

    def x(self, k: int) -> np.ndarray:
        """Returns the matrix (nx, size) that selects x_k."""
        return self.units[:, None] * self.identity[k * self.nx : (k + 1) * self.nx]

    def u(self, k: int) -> np.ndarray:
        """Returns the matrix (3 + n, size) that selects u_k."""
        first = (self.N + 1) * self.nx + k * self.m
        return self.identity[first : first + self.m]

    def stage(self, k: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Returns A, B and C over all ticks of a stage, from a power of the joint matrix."""
        model, nx = self.model, self.nx
        joint = np.eye(nx + self.m + 3)
        joint[:nx] = np.hstack([model.A, model.B, model.C])
        power = np.linalg.matrix_power(joint, stage_ticks(self.config)[k])
        return np.split(power[:nx], [nx, nx + self.m], axis=1)

    def cost(self, tick: MpcInputs):
        """Yields (L, c, w); the cost is the sum of w |L z + c|^2."""
        config, model, at = self.config, self.model, tick.end_effector
        K_e, z0 = np.array(config.k_e), np.zeros(self.size)
        q_0 = tick.x_0[model.joint_position]

        def position(x: np.ndarray) -> np.ndarray:
            moved = x[model.base_position] + at.J_c[:, 4:] @ x[model.joint_position]
            if config.tilt == "flatness":
                moved = moved + displacement(at.r, acceleration(model, x))
            return moved

        for k, ticks in enumerate(stage_ticks(config), start=1):
            x, u = self.x(k), self.u(k - 1)
            v, qdot = x[model.base_velocity], x[model.joint_velocity]
            velocity, known = v + at.J_c[:, 4:] @ qdot, at.J_c[:, 3] * tick.rpy_rates[2]
            if config.tilt == "held":
                known = known + at.J_u @ tick.rpy_rates[:2]
            if config.tilt == "flatness":
                change = acceleration(model, x) - acceleration(model, self.x(k - 1))
                velocity = velocity + displacement(at.r, change / (ticks * DT))
            p_Ed, v_Ed = tick.reference[k, :3], tick.reference[k, 3:]
            if config.error == "predicted":
                e, e_fixed = position(x), at.p_E - position(tick.x_0) - p_Ed
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
        """Yields (G, h) of the constraints G z <= h."""
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
        """Returns u_0 and the fraction of bounds that are active."""
        L, c, w = (np.concatenate(parts) for parts in zip(*self.cost(tick), strict=True))
        L, w = sparse.csc_matrix(L), 1e-4 * w  # Scaled like the multipliers of the bounds.
        P, linear = 2 * L.T @ sparse.diags(w) @ L, 2 * L.T @ (w * c)
        # Rows are scaled as well.
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
