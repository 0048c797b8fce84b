"""Online learning of the network's last layer, in closed form and with guards.

All equations here are of the velocity correction c Delta = theta phi in m/s, which Delta adds to
the predicted velocity in one period (`EquivalentModel.residual_gain`). The labels, the learning
rate and the guards therefore mean the same in every model; in the paper's model c is 1.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from aerodrake.scenario import Residual


class LearnerState(NamedTuple):
    """Last layer, and ring buffer of the latest samples. Its arrays are never changed in place.

    Attributes:
        theta: (3, m) m/s, last layer of c Delta.
        phis, targets: (B_l, m) activations and (B_l, 3) m/s targets of the samples.
        sample_count: Number of samples so far; the next one goes to row `sample_count` mod B_l.
    """

    theta: np.ndarray
    phis: np.ndarray
    targets: np.ndarray
    sample_count: int


@dataclass(frozen=True, eq=False)
class OnlineLearner:
    """The gradient step of the paper's eq. 6 (`last_layer_step`), with guards.

    Without guards, as with `residual.as_printed`, the step is the paper's. Otherwise

    - a sample is rejected while the flight controller is saturated, since the base then does
      not follow the equivalent model;
    - a sample is rejected if the offline layer mispredicts it by more than `max_error_m_s`.
      The learned layer is not used for this test: a learner that diverged would reject the
      samples that correct it;
    - a step of theta is shortened to the length `max_step`;
    - theta is projected onto the ball of radius `max_drift` about theta_offline, so that
      |c Delta - theta_offline phi| <= max_drift |phi|.

    Norms are Frobenius norms. Projecting onto a convex set that contains the old theta never
    lengthens the step. Samples with NaN or infinite entries are rejected, and a step that
    overflows is discarded.

    Attributes:
        config: Learning rate, batch and bounds.
        theta_offline: (3, m) m/s, initial last layer of c Delta.
    """

    config: Residual
    theta_offline: np.ndarray

    def start(self) -> LearnerState:
        """Returns the offline layer with an empty ring buffer."""
        batch, m = self.config.batch, self.theta_offline.shape[1]
        return LearnerState(self.theta_offline, np.zeros((batch, m)), np.zeros((batch, 3)), 0)

    def step(
        self, state: LearnerState, phi: np.ndarray, target: np.ndarray, is_saturated: bool
    ) -> LearnerState:
        """Returns the state after one more sample; `state` itself if the sample is rejected.

        Args:
            state: Before the sample.
            phi: (m,) at the time of the prediction.
            target: (3,) m/s, measured velocity minus the model's prediction without Delta.
            is_saturated: True if the flight controller was saturated in between.
        """
        # Extreme samples may overflow; the results are tested below.
        with np.errstate(over="ignore", invalid="ignore"):
            is_frozen = is_saturated and self.config.guards.freeze_saturated
            if is_frozen or not self._is_credible(phi, target):
                return state
            phis, targets = state.phis.copy(), state.targets.copy()
            row = state.sample_count % self.config.batch
            phis[row], targets[row] = phi, target
            count = state.sample_count + 1  # The buffer has the latest B_l of them.
            theta = last_layer_step(
                state.theta, phis[:count], targets[:count], self.config.learning_rate
            )
            if np.isfinite(theta).all():
                theta = _project(self.config.guards.max_step, state.theta, theta)
                theta = _project(self.config.guards.max_drift, self.theta_offline, theta)
            else:
                theta = state.theta
        return LearnerState(theta, phis, targets, count)

    def stable_learning_rate(self, state: LearnerState) -> float:
        """Returns the bound of `last_layer_step` on eta for the ring buffer; 0 if that is empty."""
        count = min(state.sample_count, self.config.batch)
        largest = np.abs(state.phis).max()
        if count == 0 or largest == 0:
            return 0.0
        phis = state.phis / largest  # Scaled, since squares might overflow.
        if phis.shape[0] > phis.shape[1]:
            phis = phis.T
        with np.errstate(over="ignore"):
            curvature = np.linalg.eigvalsh(phis @ phis.T)[-1] / count * largest**2
            return float(1 / curvature)

    def run(self, phi: np.ndarray, target: np.ndarray, saturated: np.ndarray) -> np.ndarray:
        """Returns c Delta (T, 3) m/s of the learned layer along a recorded flight, without gate.

        Delta_k uses phi_k and the theta that has learned the samples up to k-1, since the target
        of sample k is measured at k+1. Its prediction error is c Delta_k - target_k.

        Args:
            phi: (T, m) at successive ticks.
            target: (T, 3) m/s.
            saturated: (T,) flag of each sample, at the time of its target.
        """
        state, correction = self.start(), np.empty_like(target)
        for k in range(len(phi)):
            correction[k] = state.theta @ phi[k]
            state = self.step(state, phi[k], target[k], bool(saturated[k]))
        return correction

    def _is_credible(self, phi: np.ndarray, target: np.ndarray) -> bool:
        if not (np.isfinite(phi).all() and np.isfinite(target).all()):
            return False
        error = np.linalg.norm(self.theta_offline @ phi - target)
        bound = self.config.guards.max_error_m_s
        return bool(bound == 0 or error <= bound)


def last_layer_step(
    theta: np.ndarray, phi: np.ndarray, target: np.ndarray, learning_rate: float
) -> np.ndarray:
    """Returns theta after one step theta_k = theta_{k-1} - eta mean_i grad L_i (paper, eq. 6).

    L_i = || p_hat'_i - p'_i ||^2 with p_hat'_i = base_i + theta phi_i: the model's
    velocity prediction is affine in theta, so that

        grad L_i = 2 (theta phi_i - target_i) phi_i^T,    target_i = p'_i - base_i.

    In a model with c other than 1 this is, in units of c, the gradient of the squared
    error of Delta, || Delta_i - target_i / c ||^2, by the last layer of Delta.

    The printed sum over i = k-B_l..k has B_l + 1 terms and is divided by B_l; it is read as
    i = k-B_l+1..k. With fewer than B_l samples so far, the mean runs over those.

    The method is that of Saviolo et al., "Active Learning of Discrete-Time Dynamics for
    Uncertainty-Aware Model Predictive Control", 2023. The step is stable for
    eta < 1 / lambda_max, the largest eigenvalue of mean phi phi^T.

    Args:
        theta: (3, m) m/s, last layer of c Delta, [weights, bias].
        phi: (B, m) last hidden activations and a 1, B >= 1.
        target: (B, 3) m/s, measured velocity minus the model's prediction without Delta.
        learning_rate: eta.
    """
    error = phi @ theta.T - target
    gradient = 2 * error.T @ phi / len(phi)
    return theta - learning_rate * gradient


def _project(radius: float, centre: np.ndarray, theta: np.ndarray) -> np.ndarray:
    """Projects `theta` onto a ball; a radius of 0 is no bound."""
    offset = theta - centre
    distance = np.linalg.norm(offset)
    return centre + offset * (radius / distance) if 0 < radius < distance else theta
