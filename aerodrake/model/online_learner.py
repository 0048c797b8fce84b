"""Online learning of the last layer, sample by sample, with guards."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from aerodrake.compiled import compiled
from aerodrake.model.last_layer import last_layer_step
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

    def to_vector(self) -> np.ndarray:
        """All of it in one vector, for `OnlineLearner.state_of`."""
        return np.concatenate(
            [self.theta.ravel(), self.phis.ravel(), self.targets.ravel(), [self.seen]]
        )


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

    def state_of(self, x: np.ndarray) -> LearnerState:
        """The state whose `to_vector` is x; copied, since it outlives what x shows."""
        x, batch, m = x.copy(), self.config.batch, self.theta_offline.shape[1]
        phis, targets = 3 * m, 3 * m + batch * m
        return LearnerState(
            x[:phis].reshape(3, m),
            x[phis:targets].reshape(batch, m),
            x[targets:-1].reshape(batch, 3),
            int(x[-1]),
        )

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
        if saturated and self.config.freeze_saturated:
            return state
        learned, *rest = learn(
            self._rule, state.theta, state.phis, state.targets, state.seen, phi, target
        )
        return LearnerState(*rest, state.seen + 1) if learned else state

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

    @cached_property
    def _rule(self) -> Rule:
        config = self.config
        bounds = config.max_step, config.max_drift, config.max_error_m_s
        return Rule(self.theta_offline, self.gain, config.learning_rate, *bounds)


class Rule(NamedTuple):
    """An `OnlineLearner`'s constants, as compiled equations take them."""

    theta_offline: np.ndarray
    gain: np.ndarray
    learning_rate: float
    max_step: float
    max_drift: float
    max_error_m_s: float


@compiled
def learn(
    rule: Rule,
    theta: np.ndarray,
    phis: np.ndarray,
    targets: np.ndarray,
    seen: int,
    phi: np.ndarray,
    target: np.ndarray,
) -> tuple[bool, np.ndarray, np.ndarray, np.ndarray]:
    """(whether the sample is learned, theta, phis, targets) after it: see `OnlineLearner`.

    Args:
        rule: What holds.
        theta, phis, targets, seen: As in `LearnerState`; not changed.
        phi, target: The sample.
    """
    error = rule.gain * (rule.theta_offline @ phi) - target
    is_finite = np.isfinite(phi).all() and np.isfinite(target).all()
    is_credible = rule.max_error_m_s == 0 or np.sqrt(np.sum(error**2)) <= rule.max_error_m_s
    if not (is_finite and is_credible):
        return False, theta, phis, targets
    phis, targets = phis.copy(), targets.copy()
    row = seen % len(phis)
    phis[row], targets[row] = phi, target
    held = min(seen + 1, len(phis))
    new = last_layer_step(theta, phis[:held], targets[:held], rule.gain, rule.learning_rate)
    if not np.isfinite(new).all():
        return True, theta, phis, targets
    new = _within(rule.max_step, theta, new)
    return True, _within(rule.max_drift, rule.theta_offline, new), phis, targets


@compiled
def _within(radius: float, centre: np.ndarray, theta: np.ndarray) -> np.ndarray:
    """The point of a ball nearest to `theta`; `theta` itself if the radius is 0."""
    away = theta - centre
    distance = np.sqrt(np.sum(away**2))
    return centre + away * (radius / distance) if 0 < radius < distance else theta
