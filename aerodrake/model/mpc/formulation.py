"""Condensed program of the MPC (paper, section III-A, B)."""

import numpy as np

from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.model.mpc.condensing import Condensing, gradient, hessian, outputs_under
from aerodrake.model.mpc.horizon import StageResponses
from aerodrake.model.mpc.objective import stage_cost
from aerodrake.model.mpc.problem import MpcProblem
from aerodrake.model.mpc.program import MpcProgram
from aerodrake.model.mpc.tick import MpcInputs
from aerodrake.model.mpc.tick_program import TickProgram
from aerodrake.model.qp.quadratic_program import QuadraticProgram
from aerodrake.model.setpoint.integration import braking
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Mpc
from aerodrake.support.arguments import checked


class MpcFormulation(MpcProblem):
    """Forms the condensed program of one tick; constant parts are computed once.

    Attributes:
        A: (rows, m N), bounds on states as rows of unit norm.
        scale: (m N,) m/s^2 and rad/s^2, inputs per unit of z.
        condensing: Constant part of the programs.

    Args:
        config, model, vehicle: As for `MpcProblem`.
    """

    @checked
    def __init__(self, config: Mpc, model: EquivalentModel, vehicle: VehicleModel):
        super().__init__(config, model, vehicle)
        N, ticks, acceleration = config.horizon, self.stage_ticks, self.limits.acceleration
        self.scale = np.repeat(acceleration, N)
        self._setpoint_rates = np.concatenate([model.setpoint_velocity, model.joint_velocity])
        change = np.eye(N) - np.eye(N, k=-1)
        H_input = np.multiply.outer(self.objective.W_3, np.diag(ticks))
        H_input[:3] += np.multiply.outer(self.W_5, change.T @ change)
        H_input *= acceleration[:, None, None] ** 2
        responses = StageResponses(model, ticks, acceleration)
        self.condensing = Condensing.make(responses, ticks.astype(float), H_input)
        self._form_rows(responses)

    def _form_rows(self, responses: StageResponses) -> None:
        """Computes the bounds of `StateBounds` as unit-norm rows over z."""
        bounds, acceleration = self.bounds, self.limits.acceleration
        N, m = self.config.horizon, len(acceleration)

        def rows(x: np.ndarray) -> np.ndarray:
            """Returns the bounded quantities (rows, ...) of states (N, nx, ...)."""
            stop = np.tensordot(bounds.stop, x[-1], 1)
            return np.vstack([x[:, bounds.index].reshape(N * len(bounds.index), -1), stop])

        by_input = rows(responses.Gamma).reshape(-1, N, m) * acceleration
        A = by_input.transpose(0, 2, 1).reshape(-1, m * N)
        norms = np.linalg.norm(A, axis=1)
        self.A = A / norms[:, None]
        self._upper = np.concatenate([np.tile(bounds.upper, N), bounds.stop_upper]) / norms
        self._lower = np.concatenate([np.tile(bounds.lower, N), bounds.stop_lower]) / norms
        # Free response of the rows and of the outputs, per [x_0, Delta].
        of_rows = np.hstack([rows(responses.Phi), rows(responses.Psi)]) / norms[:, None]
        of_outputs = responses.free.reshape(-1, of_rows.shape[1])
        self._free_response = np.vstack([of_rows, of_outputs])

    def form(self, tick: MpcInputs) -> MpcProgram:
        """Returns the condensed program of one tick."""
        N = self.config.horizon
        response = self._free_response @ np.concatenate([tick.x_0, tick.delta])
        rows, outputs = response[: len(self.A)], response[len(self.A) :]
        free_response, predictions = outputs.reshape(-1, N), self.predictions(tick)
        cost = stage_cost(self.objective.terms(tick), predictions)
        H, g = hessian(self.condensing, cost.C), gradient(self.condensing, cost, free_response)
        g[: 3 * N : N] -= self.W_5 * self.limits.acceleration[:3] * tick.u_last[:3]
        program = MpcProgram(
            H=H,
            g=g,
            A=self.A,
            lower=self._lower - rows,
            upper=self._upper - rows,
            free_response=free_response,
            v_d=tick.x_0[self._setpoint_rates],
        )
        return self.custom.added_to(program, predictions, self.condensing, self.scale)

    def program(self, tick: MpcInputs) -> TickProgram:
        """Returns the problem of one tick with states, inputs and task vectors as variables.

        It has the definitions from which `form` derives the condensed program, for reading, for
        extending and for any solver.
        """
        return TickProgram(self, tick)

    def relaxed(self, program: MpcProgram) -> MpcProgram:
        """Returns the program with bounds widened so far that full braking is feasible.

        Bounds that full braking satisfies are unchanged. The others cannot be satisfied by
        any input, and the relaxed program exceeds them by no more than braking does. Custom
        constraints are unchanged.
        """
        return program.admitting(self._braking(program), slice(len(self.A)))

    def least_violation(self, relaxed: MpcProgram) -> QuadraticProgram:
        """Returns the program of the least violation of the custom constraints of a relaxed one.

        z begins with the m N inputs.
        """
        return relaxed.least_violation(len(self.A), self._braking(relaxed))

    def _braking(self, program: MpcProgram) -> np.ndarray:
        """Returns full braking, as z."""
        stages_s = self.model.dt * self.stage_ticks
        return braking(program.v_d, self.limits.acceleration, stages_s)

    def inputs(self, z: np.ndarray) -> np.ndarray:
        """Returns u_0 ... u_{N-1} (N, m) in m/s^2 and rad/s^2 from z (m N,)."""
        return (self.scale * z).reshape(-1, self.config.horizon).T

    def predict(self, tick: MpcInputs, program: MpcProgram, U: np.ndarray) -> np.ndarray:
        """Returns the linearised p_E (N + 1, 3) m now and at each stage under U (N, 3 + n)."""
        y = outputs_under(self.condensing, program.free_response, U.T.ravel() / self.scale)
        rows, offset = self.predictions(tick)["tool_position"]
        return np.vstack([tick.end_effector.p_E, (rows @ y + offset).T])
