"""What share of its commanded thrust each rotor gives, told by how the vehicle moves."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from aerodrake.model.low_level.rotor_lag import RotorLag, advance
from aerodrake.model.vehicle.rotation import rotation_matrix
from aerodrake.model.vehicle.vehicle import GRAVITY, VehicleModel
from aerodrake.scenario import Rotor
from aerodrake.support.compiled import compiled

FAST_S, SLOW_S, BASELINE_S = 0.035, 0.33, 3.0
"""Time constants: of what tells large losses, of what tells small ones, of what is neither."""
FIRST_S = 1.0
"""The baseline's at the start of a flight, when nothing is known of it."""

FORCE_WEIGHT = 0.1
"""Of forces beside torques over `lever`, squared, in how much is missing: velocities are noisy."""
FAST_FIT, SLOW_FIT = 0.7, 0.7
"""How much of all that is unexplained a loss must explain, of its square."""
FAST_LOSS, SLOW_LOSS = 0.2, 0.08
"""Shares of its thrust that a rotor must miss to be said to miss any."""
FAST_CHANGE, SLOW_CHANGE = 0.05, 0.02
"""And by how much more or less, once it is."""
FAST_SAMPLES = 3
"""In how many samples one after another a large loss must be seen."""
LEAST_LOAD = 0.1
"""Of its share of the weight: what a rotor must lift for anything to be said of it."""


class RotorMonitor(NamedTuple):
    """Newton's and Euler's laws for all links together, and what a rotor contributes.

    The momentum of base and arm, linear and about their centre of mass, changes by
    gravity, by the thrusts that are believed, and by a wrench that is not explained. Of
    that a slow baseline is wind, payload, or whatever else the model is off by. A rotor that
    misses a share of its thrust f_i adds that share of its signature: -f_i along the
    base's z axis, with the torques that come of it. It is said to if that alone leaves
    little unexplained: hands, gusts and loads have other directions, and so do
    rotors that are off together. Forces compare with torques over `lever`.

    Attributes:
        p_B: (k, 3) m, the rotors in the base frame.
        drag: (k,) m, torque about the base's z axis over thrust.
        lag: Of their thrust.
        trim: (k,) N.
        mass: kg.
        lever: m, root mean square distance of the rotors from the base's z axis.
        steps: How many samples late the base's are.
        fast, slow: How much of a new sample they take in.
    """

    p_B: np.ndarray
    drag: np.ndarray
    lag: RotorLag
    trim: np.ndarray
    mass: float
    lever: float
    steps: int
    fast: float
    slow: float

    @classmethod
    def make(
        cls, vehicle: VehicleModel, rotor: Rotor, trim: np.ndarray, delay_s: float, dt: float
    ) -> RotorMonitor:
        """For a vehicle.

        Args:
            vehicle: Its mass and rotors.
            rotor: Lag, and ratio of drag torque to thrust.
            trim: (k,) N, thrusts in trim.
            delay_s: s, how late the base's samples are believed to be.
            dt: s, from sample to sample.
        """
        x, y, _ = vehicle.rotors.p_B.T
        return cls(
            p_B=np.ascontiguousarray(vehicle.rotors.p_B),
            drag=-vehicle.rotors.spin * rotor.torque_ratio_m,
            lag=RotorLag(rotor.lag_up_s, rotor.lag_down_s, dt),
            trim=trim,
            mass=vehicle.mass,
            lever=float(np.sqrt(np.mean(x**2 + y**2))),
            steps=round(delay_s / dt),
            fast=float(-np.expm1(-dt / FAST_S)),
            slow=float(-np.expm1(-dt / SLOW_S)),
        )

    def initial_memory(self) -> np.ndarray:
        """(35 + 4 k + k steps,) what is remembered from one sample to the next.

        [baseline (6); fast and slow mean of what is unexplained beyond it (6 each); fast and
        slow mean of believed thrusts, thrusts now, missing shares (k each); motion at the
        last sample (13); whether that is known, s that there has been a baseline, which
        rotor is suspected, at how many samples; late thrusts (k each)].
        """
        k = len(self.trim)
        means = np.concatenate([np.zeros(18), np.tile(self.trim, 3), np.zeros(k)])
        late = np.tile(self.trim, self.steps)
        return np.concatenate([means, np.zeros(13), [0.0, FIRST_S, -1.0, 0.0], late])


@compiled
def watch(
    monitor: RotorMonitor,
    memory: np.ndarray,
    command: np.ndarray,
    motion: np.ndarray,
    is_believed: bool,
) -> tuple[np.ndarray, np.ndarray]:
    """Takes in a sample.

    Args:
        monitor: Its constants.
        memory: As `initial_memory` has it.
        command: (k,) N, the rotors' since the sample before.
        motion: (13,) of the sample: momentum (9,) as `WholeBody.momentum` has it, and the
            base's quaternion.
        is_believed: Whether the sample is. From one that is not nothing is learned, nor
            from the change since then.

    Returns:
        The memory now, and (k,) the shares of their thrusts that the rotors give.
    """
    k = len(monitor.trim)
    memory = memory.copy()
    baseline, fast, slow = memory[:6], memory[6:12], memory[12:18]
    fast_thrust, slow_thrust = memory[18 : 18 + k], memory[18 + k : 18 + 2 * k]
    thrust, missing = memory[18 + 2 * k : 18 + 3 * k], memory[18 + 3 * k : 18 + 4 * k]
    last, rest = memory[18 + 4 * k : 31 + 4 * k], memory[31 + 4 * k :]
    counts, late = rest[:4], rest[4:]

    end, mean = advance(monitor.lag, thrust, command)
    thrust[:] = end
    if monitor.steps:
        since = np.concatenate((late, mean))
        mean, late[:] = since[:k], since[k:]
    if is_believed and counts[0] > 0:
        rows, wrench = unexplained(monitor, last, motion, mean)
        wrench -= baseline
        fast += monitor.fast * (wrench - fast)
        slow += monitor.slow * (wrench - slow)
        fast_thrust += monitor.fast * (mean - fast_thrust)
        slow_thrust += monitor.slow * (mean - slow_thrust)
        is_suspect, is_sure = _suspects(
            monitor, rows * fast_thrust.reshape(k, 1), fast, missing, counts
        )
        if is_sure:  # What the slow means still know of is over.
            slow[:], slow_thrust[:] = fast, fast_thrust
        if not is_suspect:
            is_suspect = _misses_little(monitor, rows * slow_thrust.reshape(k, 1), slow, missing)
        if not is_suspect:
            baseline += monitor.lag.dt / counts[1] * (wrench - (mean * missing) @ rows)
            counts[1] = min(counts[1] + monitor.lag.dt, BASELINE_S)
    last[:], counts[0] = motion, 1.0 if is_believed else 0.0
    return memory, 1.0 - missing


@compiled
def unexplained(
    monitor: RotorMonitor, last: np.ndarray, motion: np.ndarray, thrust: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """What a rotor's loss would add per N, and what is not explained; in the base's axes.

    Args:
        monitor: Its constants.
        last, motion: (13,) at the sample before and at this one.
        thrust: (k,) N, means between the two, as believed.

    Returns:
        (k, 6) and (6,): torque about the centre of mass over `lever`, and force, in N.
    """
    R = (rotation_matrix(last[9:]) + rotation_matrix(motion[9:])) / 2
    change = (motion[:6] - last[:6]) / monitor.lag.dt
    change[5] += monitor.mass * GRAVITY
    r_BC = R.T @ ((last[6:9] + motion[6:9]) / 2)
    rows, wrench = np.zeros((len(thrust), 6)), np.empty(6)
    wrench[:3] = R.T @ change[:3] / monitor.lever
    wrench[3:] = R.T @ change[3:]
    for i in range(len(thrust)):
        rows[i, 0] = (r_BC[1] - monitor.p_B[i, 1]) / monitor.lever
        rows[i, 1] = (monitor.p_B[i, 0] - r_BC[0]) / monitor.lever
        rows[i, 2] = -monitor.drag[i] / monitor.lever
        rows[i, 5] = -1.0
    return rows, wrench + thrust @ rows


@compiled
def _suspects(
    monitor: RotorMonitor,
    signatures: np.ndarray,
    wrench: np.ndarray,
    missing: np.ndarray,
    counts: np.ndarray,
) -> tuple[bool, bool]:
    """Whether a rotor is suspected of a large loss, and if that lasts and is told in `missing`."""
    i, share, fit = _explanation(monitor, signatures, wrench, missing)
    change = abs(share - missing[i]) if fit > FAST_FIT else 0.0
    is_suspect = change > FAST_LOSS
    counts[3] = 0.0 if not is_suspect else counts[3] + 1 if counts[2] == i else 1.0
    counts[2] = i if is_suspect else -1.0
    is_sure = counts[3] >= FAST_SAMPLES or (missing[i] > FAST_LOSS and change > FAST_CHANGE)
    if is_sure:
        missing[i] = share
    return is_suspect or is_sure, is_sure


@compiled
def _misses_little(
    monitor: RotorMonitor, signatures: np.ndarray, wrench: np.ndarray, missing: np.ndarray
) -> bool:
    """Whether what a rotor misses has changed by little, which is told in `missing`."""
    i, share, fit = _explanation(monitor, signatures, wrench, missing)
    least = SLOW_CHANGE if missing[i] > 0 else SLOW_LOSS
    if not (fit > SLOW_FIT and abs(share - missing[i]) > least):
        return False
    missing[i] = share if share > SLOW_LOSS / 2 else 0.0
    return True


@compiled
def _explanation(
    monitor: RotorMonitor, signatures: np.ndarray, wrench: np.ndarray, missing: np.ndarray
) -> tuple[int, float, float]:
    """Which rotor explains a wrench best, by which share that it misses, and how much of it.

    Args:
        monitor: Its constants.
        signatures: (k, 6) N, what all of a rotor's thrust missing adds.
        wrench: (6,) N, unexplained by any.
        missing: (k,) what rotors are known to miss; the others' part is taken off.
    """
    found, found_share, least = 0, 0.0, 1.0
    load = LEAST_LOAD * monitor.mass * GRAVITY / len(missing)
    known = wrench - missing @ signatures
    for i in range(len(missing)):
        g = signatures[i]
        if -g[5] < load:
            continue
        own = known + missing[i] * g
        product = g[:3] @ own[:3] + FORCE_WEIGHT * (g[3:] @ own[3:])
        size = g[:3] @ g[:3] + FORCE_WEIGHT * (g[3:] @ g[3:])
        share = min(max(product / size, 0.0), 1.0)
        left = own - share * g
        # What is over is nothing to be explained: then what was missing is the scale.
        scale = max(own @ own, missing[i] ** 2 * (g @ g))
        if left @ left < least * scale:
            found, found_share, least = i, share, (left @ left) / scale
    return found, found_share, 1.0 - least
