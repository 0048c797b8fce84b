"""Online learning of the network's last layer, in closed form."""

from __future__ import annotations

import numpy as np


def last_layer_step(
    theta: np.ndarray,
    phi: np.ndarray,
    target: np.ndarray,
    gain: np.ndarray,
    learning_rate: float,
) -> np.ndarray:
    """One step of theta_k = theta_{k-1} - eta mean_i grad L_i (paper, eq. 6).

    L_i = || p_hat'_i - p'_i ||^2 with p_hat'_i = base_i + c * (theta phi_i): the
    model's velocity prediction is affine in theta, so that

        grad L_i = 2 diag(c) (c * (theta phi_i) - target_i) phi_i^T,
        target_i = p'_i - base_i.

    The printed sum over i = k-B_l..k has B_l + 1 terms and is divided by B_l; it
    is read as i = k-B_l+1..k. While fewer than B_l samples have been seen, the
    mean runs over those.

    The method is that of Saviolo et al., "Active Learning of Discrete-Time
    Dynamics for Uncertainty-Aware Model Predictive Control", 2023. The step is
    stable for eta c^2 < 1 / lambda_max, the largest eigenvalue of mean phi phi^T.

    Args:
        theta: (3, m) last layer, [weights, bias].
        phi: (B, m) last hidden activations and a 1, B >= 1.
        target: (B, 3) m/s, measured velocity minus the model's prediction
            without Delta.
        gain: (3,) c, the diagonal of the model's C in the rows of p_B'.
        learning_rate: eta.

    Returns:
        (3, m) the new theta.
    """
    error = gain * (phi @ theta.T) - target
    gradient = 2 * (gain * error).T @ phi / len(phi)
    return theta - learning_rate * gradient
