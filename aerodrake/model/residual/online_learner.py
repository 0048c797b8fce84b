"""Online learning of the last layer, sample by sample, with guards."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from aerodrake.model.residual.last_layer import last_layer_step
from aerodrake.scenario import Residual


@dataclass(frozen=True, eq=False)
class LearnerState:
    """What has been learned, and the latest samples: never changed in place.

    Attributes:
        theta: (3, m) m/s, last layer.
        phis: (B_l, m) ring of the samples' activations.
        targets: (B_l, 3) m/s, ring of their targets.
        seen: Samples that have entered the ring; the next goes to `seen` mod B_l.
    """

    theta: np.ndarray
    phis: np.ndarray
    targets: np.ndarray
    seen: int


@dataclass(frozen=True, eq=False)
class OnlineLearner:
    """The step of the paper's eq. 6 (`last_layer_step`), and guards around it.

    With its three bounds 0 and `freeze_saturated` false the step is the paper's.
    Otherwise

    - a sample is not learned and not kept while the flight controller is
      saturated: the base then does not do what the model is about;
    - nor is one that the network as trained offline mispredicts by more than
      `max_error_m_s`. That the judge does not learn keeps a learner that went
      astray from refusing all that would bring it back;
    - a step of theta is shortened to `max_step`;
    - theta is projected onto the ball of `max_drift` about theta_offline, so that
      |Delta - theta_offline phi| <= max_drift |phi|, whatever was learned.

    Norms are Frobenius norms. A projection onto a convex set that holds the old
    theta never lengthens the step. A sample that is not finite is never kept, and
    a step that overflows is not taken.

    Attributes:
        config: Learning rate, batch and bounds.
        theta_offline: (3, m) m/s, where learning starts.
        gain: (3,) c, the diagonal of the model's C in the rows of p_B'.
    """

    config: Residual
    theta_offline: np.ndarray
    gain: np.ndarray

    def start(self) -> LearnerState:
        """The state in which nothing has been seen."""
        batch, m = self.config.batch, self.theta_offline.shape[1]
        return LearnerState(self.theta_offline, np.zeros((batch, m)), np.zeros((batch, 3)), 0)

    def step(
        self, state: LearnerState, phi: np.ndarray, target: np.ndarray, saturated: bool
    ) -> LearnerState:
        """Learns from one more sample, or leaves the state as it is.

        Args:
            state: Before the sample.
            phi: (m,) when the prediction was made.
            target: (3,) m/s, the velocity that came of it minus the model's
                prediction without Delta.
            saturated: Whether the flight controller was, in between.
        """
        # Samples may be as wild as floats are; what they give is looked at below.
        with np.errstate(over="ignore", invalid="ignore"):
            if (saturated and self.config.freeze_saturated) or not self._is_credible(phi, target):
                return state
            phis, targets = state.phis.copy(), state.targets.copy()
            row = state.seen % self.config.batch
            phis[row], targets[row] = phi, target
            seen = state.seen + 1
            held = slice(min(seen, self.config.batch))
            theta = self._guard(
                state.theta,
                last_layer_step(
                    state.theta, phis[held], targets[held], self.gain, self.config.learning_rate
                ),
            )
        return LearnerState(theta, phis, targets, seen)

    def run(self, phi: np.ndarray, target: np.ndarray, saturated: np.ndarray) -> np.ndarray:
        """Delta as the residual estimator would have inferred it along a recorded flight.

        Delta_k is that of phi_k and of the theta that has learned the samples up
        to k-1, since the target of the sample k is measured at k+1. Its error is
        gain * Delta_k - target_k.

        Args:
            phi: (T, m) at successive ticks.
            target: (T, 3) m/s.
            saturated: (T,) of each sample: the flag as read when its target is
                measured, one tick after its phi.

        Returns:
            (T, 3) m/s.
        """
        state, delta = self.start(), np.empty_like(target)
        for k in range(len(phi)):
            delta[k] = state.theta @ phi[k]
            state = self.step(state, phi[k], target[k], bool(saturated[k]))
        return delta

    def _is_credible(self, phi: np.ndarray, target: np.ndarray) -> bool:
        if not (np.isfinite(phi).all() and np.isfinite(target).all()):
            return False
        error = np.linalg.norm(self.gain * (self.theta_offline @ phi) - target)
        most = self.config.max_error_m_s
        return bool(most == 0 or error <= most)

    def _guard(self, old: np.ndarray, new: np.ndarray) -> np.ndarray:
        if not np.isfinite(new).all():
            return old
        new = _within(self.config.max_step, old, new)
        return _within(self.config.max_drift, self.theta_offline, new)


def _within(radius: float, centre: np.ndarray, theta: np.ndarray) -> np.ndarray:
    """The point of a ball nearest to `theta`; `theta` itself if the radius is 0."""
    away = theta - centre
    distance = np.linalg.norm(away)
    return centre + away * (radius / distance) if 0 < radius < distance else theta
