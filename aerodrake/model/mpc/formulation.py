"""Cost and bounds of the MPC (paper, section III-A, B): the program of one tick."""

import copy
from typing import Self

import numpy as np

from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.model.mpc.condensing import (
    Condensing,
    gradient,
    hessian,
    outputs_under,
)
from aerodrake.model.mpc.custom_terms import CustomTerm, CustomTerms
from aerodrake.model.mpc.horizon import StageResponses, stage_ticks
from aerodrake.model.mpc.objective import Objective, input_cost, stage_cost
from aerodrake.model.mpc.predictions import StagePredictions
from aerodrake.model.mpc.program import MpcProgram
from aerodrake.model.mpc.state_bounds import StateBounds
from aerodrake.model.mpc.tick import MpcInputs
from aerodrake.model.mpc.tick_program import TickProblem, TickProgram
from aerodrake.model.qp.quadratic_program import QuadraticProgram
from aerodrake.model.setpoint.integration import SetpointLimits, braking
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Mpc


class MpcFormulation:
    """Forms the program of one tick; constant parts are computed once.

    The objective is the sum over the stages 1 ... N (of J_3 and J_5: 0 ... N-1, since u_N has no
    effect) of the terms of `Objective` and of

        J_3 = | u_k |^2                     W_3
        J_5 = | p_B,d,k'' - p_B,d,k-1'' |^2 W_5

    All but J_5 are multiplied by the ticks that a stage lasts. J_5 is not in the paper. It
    penalises steps of the base acceleration, from the current one on: such steps
    require attitude rates beyond those of the rotors, and rotate the end-effector.

    `config.tilt` selects the prediction of roll and pitch. `none`: they are constant. `held`:
    their measured rates are constant over the horizon. `flatness`: the thrust axis tilts with the
    model's acceleration a of the base, which moves the end-effector by T a, T = -[r]x [z]x / g,
    at the mean rate T (a_k - a_{k-1}) / (t_k - t_{k-1}); in models without a, as `none`.

    Attributes:
        A: (rows, m N), bounds on states as rows of unit norm.

    Args:
        config: Weights, horizon and limits of the base.
        model: The equivalent model.
        vehicle: Gives the centre of the learning space and the limits of the joints.
    """

    def __init__(self, config: Mpc, model: EquivalentModel, vehicle: VehicleModel):
        self.config, self.model = config, model
        self.limits = limits = SetpointLimits.make(config, vehicle)
        self.stage_ticks = ticks = stage_ticks(config)
        self.scale = np.repeat(limits.acceleration, config.horizon)
        self.objective = Objective(config, vehicle)
        self._setpoint_rates = np.concatenate([model.setpoint_velocity, model.joint_velocity])
        # The measured yaw rate is used always, those of roll and pitch only with tilt `held`.
        self._rates = np.array([1.0, 1.0, 1.0] if config.tilt == "held" else [0.0, 0.0, 1.0])
        w_3_joints = vehicle.per_joint(config.w_3_joints, "mpc.w_3_joints")
        self.W_3 = np.array([*config.w_3_base, *w_3_joints])
        self.W_5 = np.array([*config.w_5, *np.zeros(model.joints)])
        change = np.eye(config.horizon) - np.eye(config.horizon, k=-1)
        H_input = np.multiply.outer(self.W_3, np.diag(ticks))
        H_input += np.multiply.outer(self.W_5, change.T @ change)
        H_input *= limits.acceleration[:, None, None] ** 2
        responses = StageResponses(model, ticks, limits.acceleration)
        self.condensing = Condensing.make(responses, ticks.astype(float), H_input)
        self.bounds = StateBounds.make(model, limits)
        self.custom = CustomTerms((), self.condensing, limits.acceleration)
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

    def extended(self, *terms: CustomTerm) -> Self:
        """Returns a formulation with further costs and constraints.

        Raises:
            BadInput: if a term does not fit this formulation.
        """
        extended = copy.copy(self)
        extended.custom = CustomTerms(
            (*self.custom.terms, *terms), self.condensing, self.limits.acceleration
        )
        return extended

    def form(self, tick: MpcInputs) -> MpcProgram:
        """Returns the condensed program of one tick."""
        N = self.config.horizon
        response = self._free_response @ np.concatenate([tick.x_0, tick.delta])
        rows, outputs = response[: len(self.A)], response[len(self.A) :]
        free_response, predictions = outputs.reshape(-1, N), self.predictions(tick)
        cost = stage_cost(self.objective.terms(tick), predictions)
        H, g = hessian(self.condensing, cost.C), gradient(self.condensing, cost, free_response)
        g[::N] -= self.W_5 * self.limits.acceleration * tick.u_last
        program = MpcProgram(
            H=H,
            g=g,
            A=self.A,
            lower=self._lower - rows,
            upper=self._upper - rows,
            free_response=free_response,
            v_d=tick.x_0[self._setpoint_rates],
        )
        return self.custom.added_to(program, predictions)

    def program(self, tick: MpcInputs) -> TickProgram:
        """Returns the program of one tick with states, inputs and task vectors as variables.

        It has the definitions from which `form` derives the condensed program, for reading, for
        extending and for any solver.
        """
        return TickProgram(
            TickProblem(
                model=self.model,
                ticks=self.stage_ticks,
                terms=[*self.objective.terms(tick), input_cost(self.W_3)],
                W_5=self.W_5[:3],
                acceleration=self.limits.acceleration,
                bounds=self.bounds,
                custom=self.custom,
                predictions=self.predictions(tick),
                tick=tick,
            )
        )

    def predictions(self, tick: MpcInputs) -> StagePredictions:
        """Returns the predicted quantities of one tick."""
        rpy_rates = tick.rpy_rates * self._rates
        return StagePredictions(tick, self.model, self.config.tilt == "flatness", rpy_rates)

    def relaxed(self, program: MpcProgram) -> MpcProgram:
        """Returns the program with bounds widened so far that full braking is feasible.

        Bounds that full braking satisfies are unchanged. The others cannot be satisfied by
        any input, and the relaxed program exceeds them by no more than braking does. Custom
        constraints are unchanged.
        """
        return program.admitting(self._braking(program), slice(len(self.A)))

    def least_violation(self, program: MpcProgram) -> QuadraticProgram:
        """Returns the program of the least violation of the custom constraints.

        The bounds of a program are relaxed first. z begins with the m N inputs.
        """
        relaxed = self.relaxed(program)
        return relaxed.least_violation(len(self.A), self._braking(program))

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
        rows, offset = self.predictions(tick).tool_position
        return np.vstack([tick.end_effector.p_E, (rows @ y + offset).T])
