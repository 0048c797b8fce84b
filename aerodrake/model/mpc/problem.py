"""Definition of the MPC's problem (paper, section III-A, B)."""

import copy
from typing import Self

import numpy as np

from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.model.mpc.custom_terms import CustomTerm, CustomTerms
from aerodrake.model.mpc.horizon import stage_ticks
from aerodrake.model.mpc.objective import Objective
from aerodrake.model.mpc.predictions import StagePredictions
from aerodrake.model.mpc.state_bounds import StateBounds
from aerodrake.model.mpc.tick import MpcInputs
from aerodrake.model.setpoint.integration import SetpointLimits
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Mpc


class MpcProblem:
    """Objective, model and bounds of the MPC (paper, eq. 7 and 8).

        min   sum of J_1 ... J_6 over the stages 1 ... N  (J_3, J_5: 0 ... N-1)
        s.t.  x_0 = x_init,  x_{k+1} = A x_k + B u_k + C Delta,  x_k in X,  u_k in U

    Stage k begins at x_{k-1} and ends at x_k, with the input u_{k-1}. A, B and C are those of its
    duration (`StageTransition`). With v_s = [p_B', q'] and e_E = p_E - p_Ed,

        J_1 = | p_E' - p_Ed' + K_e e_E |^2       W_1
        J_2 = | v_s |^2                          W_2
        J_3 = | u |^2                            W_3
        J_4 = | p_EB - p_O |^2                   W_4
        J_5 = | p_B,d,k'' - p_B,d,k-1'' |^2      W_5
        J_6 = | t' - d' + K_o (t - d) |^2        W_6

    All but J_5 are multiplied by the ticks that a stage lasts. u_N has no effect and no cost.

    J_5 is not in the paper. It penalises steps of the base acceleration, from the current one
    on: such steps require attitude rates beyond those of the rotors, and rotate the end-effector.

    `config.tilt` selects the prediction of roll and pitch. `none`: they are constant. `held`:
    their measured rates are constant over the horizon. `flatness`: the thrust axis tilts with the
    model's acceleration a of the base, which moves the end-effector by T a, T = -[r]x [z]x / g,
    at the mean rate T (a_k - a_{k-1}) / (t_k - t_{k-1}); in models without a, as `none`.

    Attributes:
        config, model: As given.
        limits: Bounds of the setpoints; those of the inputs are `limits.acceleration`, the set U.
        bounds: Bounds of the states, the set X.
        stage_ticks: (N,), ticks that each stage lasts.
        objective: Terms of the objective but J_5.
        W_5: (3,), diagonal.
        custom: Custom costs and constraints.

    Args:
        config: Weights, horizon and limits of the base.
        model: The equivalent model.
        vehicle: Gives the centre of the learning space and the limits of the joints.
    """

    def __init__(self, config: Mpc, model: EquivalentModel, vehicle: VehicleModel):
        self.config, self.model = config, model
        self.limits = SetpointLimits.make(config, vehicle)
        self.bounds = StateBounds.make(model, self.limits)
        self.stage_ticks = stage_ticks(config)
        self.objective, self.W_5 = Objective(config, vehicle), np.array(config.w_5)
        self.custom = CustomTerms((), model.joints, self.stage_ticks)
        # The measured yaw rate is always used, those of roll and pitch only with tilt `held`.
        self._rates = np.array([1.0, 1.0, 1.0] if config.tilt == "held" else [0.0, 0.0, 1.0])

    def extended(self, *terms: CustomTerm) -> Self:
        """Returns a copy with further costs and constraints.

        Raises:
            BadInput: if a term does not fit.
        """
        extended, joints = copy.copy(self), self.model.joints
        extended.custom = CustomTerms((*self.custom.terms, *terms), joints, self.stage_ticks)
        return extended

    def predictions(self, tick: MpcInputs) -> StagePredictions:
        """Returns the predicted quantities of one tick."""
        rpy_rates = tick.rpy_rates * self._rates
        return StagePredictions(tick, self.model, self.config.tilt == "flatness", rpy_rates)
