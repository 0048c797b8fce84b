"""Problem of one tick as a `MathematicalProgram` that can be read, extended and solved."""

from collections.abc import Iterable, Sequence

import numpy as np
from pydrake.solvers import Binding, MathematicalProgram
from pydrake.symbolic import Variable

from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.model.mpc.custom_terms import ConstraintAtStages
from aerodrake.model.mpc.horizon import OutputMap, StageTransition
from aerodrake.model.mpc.objective import CostTerm
from aerodrake.model.mpc.problem import MpcProblem
from aerodrake.model.mpc.tick import MpcInputs

AXES = "xyz"

SYMBOLS = {
    "tool_position": "p_E",
    "tool_velocity": "p_E'",
    "tool_position_base": "p_EB",
    "tool_velocity_base": "p_EB'",
    "tool_axis": "t",
    "tool_axis_rate": "t'",
}
"""Symbols of the quantities that are variables of their own, with equations for definitions."""

DEFINITIONS = {
    "tool_position": "p_E + J_s [p_B - p_B,0; q - q_0]",
    "tool_velocity": "J_s [p_B'; q'] + J_yaw yaw' + J_u xi_u'",
    "tool_position_base": "p_EB + J_B (q - q_0)",
    "tool_velocity_base": "J_B q'",
    "tool_axis": "t + J_s [p_B - p_B,0; q - q_0]",
    "tool_axis_rate": "J_s [p_B'; q'] + J_yaw yaw' + J_u xi_u'",
}
"""Definitions of these variables, in the symbols of `StagePredictions`."""

TILTS = {"tool_position": " + T (a - a_0)", "tool_velocity": " + T a'"}
TILTS |= {"tool_axis": TILTS["tool_position"], "tool_axis_rate": TILTS["tool_velocity"]}
"""Summands of the definitions if the base's acceleration tilts it."""


class TickProgram(MathematicalProgram):
    """The MPC's problem at one tick (paper, eq. 7), with all its variables.

    Costs and constraints are described; `str` lists them. Units are SI. Decision variables at
    the beginning (k = 0) and at the end of each stage k:

    - x[k], the states of the equivalent model, such as `p_Bx[1]` and `q_2'[1]`;
    - u[k] from then on, such as `p_Bx,d''[0]`, up to k = N - 1;
    - the task vectors p_E, p_E', p_EB and, with an orientation task, t and t', such as
      `p_Ez[1]`, from k = 1 on.

    Attributes:
        x: (N + 1, nx), variables of the states.
        u: (N, m), variables of the inputs.
        task: Variables (N, 3) of each task vector, by its name in `QUANTITIES`.

    Args:
        problem: Model, objective and bounds.
        tick: Inputs of the tick.
    """

    def __init__(self, problem: MpcProblem, tick: MpcInputs):
        super().__init__()
        self._problem, self._tick, self._ticks = problem, tick, problem.stage_ticks
        model, objective = problem.model, problem.objective
        terms = [*objective.terms(tick), objective.input_cost()]
        N = len(self._ticks)
        self.x = np.array([self._variables(_state_names(model), k) for k in range(N + 1)])
        self.u = np.array([self._variables(_input_names(model.joints), k) for k in range(N)])
        custom = [cost.term for cost in problem.custom.costs] + problem.custom.constraints
        quantities = dict.fromkeys(name for term in terms + custom for name, _ in term.parts)
        self.task = {
            name: np.array(
                [self._variables([SYMBOLS[name] + axis for axis in AXES], k + 1) for k in range(N)]
            )
            for name in quantities
            if name in SYMBOLS
        }
        self._add_model()
        self._add_task_vectors()
        for term in sorted(terms, key=lambda term: term.name):
            self._add_cost(term, range(1, N + 1))
        self._add_acceleration_steps()
        self._add_bounds()
        self._add_custom_terms()

    def __str__(self) -> str:
        equations, boxes = self.linear_equality_constraints(), self.bounding_box_constraints()
        first = [*equations, *boxes]
        others = [binding for binding in self.GetAllConstraints() if binding not in first]
        lines = ["minimise", *map(_described, self.GetAllCosts()), "subject to"]
        return "\n".join([*lines, *map(_described, [*first, *others])])

    def quantity(self, name: str, k: int) -> np.ndarray:
        """Returns the variables (size,) of one of `QUANTITIES` at stage k, from 1 to N."""
        model, x = self._problem.model, self.x[k]
        if name in self.task:
            return self.task[name][k - 1]
        if name == "input":
            return self.u[k - 1]
        index = {
            "base_position": model.base_position,
            "base_velocity": model.base_velocity,
            "joint_position": model.joint_position,
            "joint_velocity": model.joint_velocity,
        }
        return x[index[name]]

    def _combination(
        self, parts: Sequence[tuple[str, np.ndarray]], k: int
    ) -> tuple[np.ndarray, np.ndarray]:
        """Returns M and the variables x at stage k, where M x is sum_i M_i x_i of the parts."""
        M = np.hstack([M for _, M in parts])
        return M, np.concatenate([self.quantity(name, k) for name, _ in parts])

    def _variables(self, names: Sequence[str], k: int) -> np.ndarray:
        variables = np.array([Variable(f"{name}[{k}]") for name in names])
        self.AddDecisionVariables(variables)
        return variables

    def _add_equation(self, M: np.ndarray, variables: np.ndarray, b: np.ndarray, what: str) -> None:
        """Adds M variables = b."""
        self.AddLinearEqualityConstraint(M, b, variables).evaluator().set_description(what)

    def _add_model(self) -> None:
        """Adds x_0 and the equivalent model over each stage."""
        tick, identity = self._tick, np.eye(self.x.shape[1])
        self._add_equation(identity, self.x[0], tick.x_0, "x[0] = x_init")
        for k, ticks in enumerate(self._ticks):
            A, B, C = StageTransition.of(self._problem.model, ticks)
            self._add_equation(
                np.hstack([identity, -A, -B]),
                np.concatenate([self.x[k + 1], self.x[k], self.u[k]]),
                C @ tick.delta,
                f"x[{k + 1}] = A x[{k}] + B u[{k}] + C Delta over {_duration(ticks)}",
            )

    def _add_task_vectors(self) -> None:
        """Adds the definitions of the task vectors in terms of the states."""
        model, predictions = self._problem.model, self._problem.predictions(self._tick)
        for name, variables in self.task.items():
            definition = DEFINITIONS[name] + (TILTS.get(name, "") if predictions.tilts else "")
            rows, offset = predictions[name]
            for k, ticks in enumerate(self._ticks):
                now, before, first = (rows @ y for y in OutputMap.of(model, ticks * model.dt))
                by_states = (now, before, first) if k else (now, before + first)
                states = (self.x[k + 1], self.x[k], self.x[0])[: len(by_states)]
                self._add_equation(
                    np.hstack([np.eye(3), *(-M for M in by_states)]),
                    np.concatenate([variables[k], *states]),
                    offset[:, 0],
                    f"{SYMBOLS[name]}[{k + 1}] = {definition}",
                )

    def _add_cost(self, term: CostTerm, stages: Iterable[int]) -> None:
        """Adds a term at some stages, from 1 to N."""
        desired = np.broadcast_to(term.desired, (len(term.weight), len(self._ticks))).T
        weights = ", ".join(f"{w:.4g}" for w in term.weight)
        for k in stages:
            M, variables = self._combination(term.parts, k)
            ticks, name = self._ticks[k - 1], _indexed(term, k)
            what = f"{name} = {term.formula} x {_duration(ticks)}, W = diag({weights})"
            self._add_squares(M, variables, desired[k - 1], ticks * term.weight, what)

    def _add_squares(
        self, M: np.ndarray, variables: np.ndarray, d: np.ndarray, W: np.ndarray, what: str
    ) -> None:
        """Adds | M variables - d |^2 W."""
        weighted = M.T * W
        cost = self.AddQuadraticCost(
            2 * weighted @ M, -2 * weighted @ d, W @ d**2, variables, is_convex=True
        )
        cost.evaluator().set_description(what)

    def _add_acceleration_steps(self) -> None:
        """Adds J_5 if it has a weight."""
        M, W_5 = np.eye(3), self._problem.W_5
        if not W_5.any():
            return
        for k, u in enumerate(self.u[:, :3]):
            what = f"J_5[{k}] = | p_B,d''[{k}] - p_B,d''[{k - 1}] |^2 W_5"
            if k == 0:
                self._add_squares(M, u, self._tick.u_last[:3], W_5, what)
            else:
                both = np.concatenate([u, self.u[k - 1, :3]])
                self._add_squares(np.hstack([M, -M]), both, np.zeros(3), W_5, what)

    def _add_bounds(self) -> None:
        """Adds the sets U and X."""
        bounds, u_max = self._problem.bounds, self._problem.limits.acceleration
        n, names = self._problem.model.joints, ("p_B,d'", "q", "q'")
        parts = np.split(np.arange(3 + 2 * n), [3, 3 + n])
        for k, u in enumerate(self.u):
            self._add_box(u, -u_max, u_max, f"u[{k}] in U: accelerations of base and joints")
        for k, x in enumerate(self.x[1:], start=1):
            for name, part in zip(names, parts, strict=True):
                low, high = bounds.lower[part], bounds.upper[part]
                self._add_box(x[bounds.index[part]], low, high, f"{name}[{k}] in X")
        stop = self.AddLinearConstraint(
            bounds.stop, bounds.stop_lower, bounds.stop_upper, self.x[-1]
        )
        N = len(self.u)
        stop.evaluator().set_description(f"q[{N}] + t_s q'[{N}] in X: the joints can stop")

    def _add_box(self, variables: np.ndarray, low: np.ndarray, high: np.ndarray, what: str) -> None:
        box = self.AddBoundingBoxConstraint(low, high, variables)
        box.evaluator().set_description(what)

    def _add_custom_terms(self) -> None:
        """Adds the costs and constraints of `MpcFormulation.extended`."""
        custom = self._problem.custom
        for cost, stages in custom.costs:
            self._add_cost(cost, stages)
        for term in custom.constraints:
            for k in term.stages:
                M, variables = self._combination(term.parts, k)
                rows = self.AddLinearConstraint(M, term.lower, term.upper, variables)
                what = f"{_indexed(term, k)}: lower <= {term.formula} <= upper"
                rows.evaluator().set_description(what)


def _described(binding: Binding) -> str:
    return f"  {binding.evaluator().get_description() or binding}"


def _indexed(term: CostTerm | ConstraintAtStages, k: int) -> str:
    """Returns the name of a term in stage k, with the index of its variables."""
    return f"{term.name}[{k - 1 if term.parts[0][0] == 'input' else k}]"


def _duration(count: int) -> str:
    return f"{count} tick" if count == 1 else f"{count} ticks"


def _state_names(model: EquivalentModel) -> list[str]:
    symbols = {"p": "p_B{}", "v": "p_B{}'", "p_d": "p_B{},d", "v_d": "p_B{},d'"}
    base = [
        symbols.get(state, state + "_{}").format(axis)
        for axis in AXES
        for state in model.axis_states
    ]
    return base + [f"q_{i + 1}{rate}" for i in range(model.joints) for rate in ("", "'")]


def _input_names(joints: int) -> list[str]:
    return [f"p_B{axis},d''" for axis in AXES] + [f"q_{i + 1}''" for i in range(joints)]
