"""Detection and isolation of rotor faults from the measured momentum of the vehicle."""

from typing import NamedTuple, Self

import numpy as np

from aerodrake.model.low_level.rotor_lag import RotorLag, advance
from aerodrake.model.vehicle.rotation import rotation_matrix
from aerodrake.model.vehicle.vehicle import GRAVITY, VehicleModel
from aerodrake.scenario import Rotor
from aerodrake.support.arguments import Count, Duration, Period, Vector, checked
from aerodrake.support.compiled import compiled

FAST_S, SLOW_S, BASELINE_S = 0.035, 0.33, 3.0
"""Time constants of the filters for large losses, for small losses, and of the baseline."""
BASELINE_START_S = 1.0
"""Time constant of the baseline at the start of a flight; it grows to `BASELINE_S`."""

FORCE_WEIGHT = 0.1
"""Weight of squared forces relative to squared torques over `lever`: velocities are noisy."""
FAST_FIT, SLOW_FIT = 0.7, 0.7
"""Least goodness of fit, 1 - |residual left|^2 / |residual|^2, at which a loss is isolated."""
FAST_LOSS, SLOW_LOSS = 0.2, 0.08
"""Detection thresholds: least fraction of thrust lost that is reported for a healthy rotor. For
small losses it is larger while the time constant of the baseline is shorter than `BASELINE_S`."""
FAST_CHANGE, SLOW_CHANGE = 0.05, 0.02
"""Least change by which the reported loss of a faulty rotor is updated."""
FAST_SAMPLES = 3
"""Consecutive samples in which a large loss is detected before it is reported."""
FAST, SLOW = 0, 1
"""Rows of filtered quantities: filter for large losses and filter for small ones."""
LEAST_LOAD = 0.1
"""Least thrust at which a rotor is diagnosed, relative to its equal part of the weight."""


class RotorMonitor(NamedTuple):
    """Momentum balance of all links together, and the fault signature of each rotor.

    The momentum of base and arm, linear and about their centre of mass, changes by gravity, by
    the estimated thrusts and by a residual wrench. A slow baseline absorbs wind, payload and
    model mismatch. A rotor that loses a fraction of its thrust f_i adds this fraction of its
    fault signature to the residual: -f_i along the base's z axis and the torques that follow.
    The loss is isolated if it alone explains most of the residual. Pushes, gusts and loads have
    other directions, and so have simultaneous losses of several rotors. Torques are divided by
    `lever` to compare with forces.

    Attributes:
        p_B: (k, 3) m, rotor positions in the base frame.
        drag: (k,) m, torque about the base's z axis over thrust.
        lag: First-order lag of thrust; its `dt` is the sample period.
        trim: (k,) N, thrusts in trim.
        mass: kg.
        lever: m, root mean square distance of the rotors from the base's z axis.
        delay_samples: Assumed delay of the base's samples.
        filter_gains: (m, 2, 1) weights of a new sample in the fast and in the slow filter, by the
            sample periods since the last one. After more than m the last one is not used.
    """

    p_B: np.ndarray
    drag: np.ndarray
    lag: RotorLag
    trim: np.ndarray
    mass: float
    lever: float
    delay_samples: int
    filter_gains: np.ndarray

    @classmethod
    @checked
    def make(
        cls,
        vehicle: VehicleModel,
        rotor: Rotor,
        trim: Vector,
        delay_s: Duration,
        dt: Period,
        samples: Count = 1,
    ) -> Self:
        """Returns the monitor of a vehicle.

        Args:
            vehicle: Mass and rotor positions.
            rotor: Lag, and ratio of drag torque to thrust.
            trim: (k,) N, thrusts in trim.
            delay_s: s, assumed delay of the base's samples.
            dt: s, sample period.
            samples: Number of sample periods after which all groups have new samples.
        """
        times = dt * np.arange(1, samples + 1)[:, np.newaxis, np.newaxis]
        x, y, _ = vehicle.rotors.p_B.T
        return cls(
            p_B=np.ascontiguousarray(vehicle.rotors.p_B),
            drag=-vehicle.rotors.spin * rotor.torque_ratio_m,
            lag=RotorLag(rotor.lag_up_s, rotor.lag_down_s, dt),
            trim=trim,
            mass=vehicle.mass,
            lever=float(np.sqrt(np.mean(x**2 + y**2))),
            delay_samples=round(delay_s / dt),
            filter_gains=-np.expm1(-times / np.array([[FAST_S], [SLOW_S]])),
        )


class MomentumSample(NamedTuple):
    """Momentum of base and arm in the world frame, and attitude of the base, at a sample.

    Attributes:
        momentum: (6,) spatial momentum about the centre of mass: angular, N m s; linear, N s.
        r_BC: (3,) m, from the base's origin to the centre of mass.
        quaternion: (4,) attitude of the base, w first.
        is_valid: False if the sample was rejected; then the other fields have no meaning.
    """

    momentum: np.ndarray
    r_BC: np.ndarray
    quaternion: np.ndarray
    is_valid: bool = True


NO_SAMPLE = MomentumSample(np.zeros(6), np.zeros(3), np.zeros(4), is_valid=False)
"""Stored in place of a rejected sample."""


class RotorMonitorState(NamedTuple):
    """State of the monitor after a sample. Wrenches (6,) are torque over `lever` and force, in N.

    Attributes:
        baseline: (6,) N, residual wrench without rotor faults.
        filtered: (2, 6 + k) N, residual beyond the baseline, and estimated thrusts, by the
            fast and by the slow filter.
        thrust: (k,) N, estimated thrusts now.
        delayed_thrust: (D, k) N, mean thrusts of the last D = `delay_samples`, oldest first.
        loss: (k,) in [0, 1], reported loss of each rotor as a fraction of its thrust.
        detections: (k,) consecutive samples in which a large loss of each rotor was detected.
        last: The last valid sample; after m sample periods without one, a sample that is not valid.
        baseline_s: s, time constant of the baseline now.
        waited: Number of sample periods since `last`.
        waited_thrust: (k,) N, sum of the mean thrusts in them.
    """

    baseline: np.ndarray
    filtered: np.ndarray
    thrust: np.ndarray
    delayed_thrust: np.ndarray
    loss: np.ndarray
    detections: np.ndarray
    last: MomentumSample
    baseline_s: float
    waited: float
    waited_thrust: np.ndarray

    @classmethod
    def initial(cls, monitor: RotorMonitor) -> Self:
        """Returns the state in trim, before the first sample."""
        trim, no_rotor, zero = monitor.trim, np.zeros(len(monitor.trim)), np.zeros(6)
        filtered = np.tile(np.concatenate([zero, trim]), (2, 1))
        delayed = np.tile(trim, (monitor.delay_samples, 1))
        start = no_rotor, no_rotor, NO_SAMPLE, BASELINE_START_S, 0.0, no_rotor
        return cls(zero, filtered, trim, delayed, *start)


@compiled
def update_monitor(
    monitor: RotorMonitor,
    state: RotorMonitorState,
    command: np.ndarray,
    sample: MomentumSample,
) -> RotorMonitorState:
    """Returns the state after one more sample.

    Args:
        monitor: Its constants.
        state: State after the sample before.
        command: (k,) N, thrust commands since the sample before.
        sample: Momentum and attitude now. If rejected, only the thrust estimate is updated.
    """
    k, waited = len(monitor.trim), state.waited + 1.0
    dt, last = waited * monitor.lag.dt, state.last
    loss, detections = state.loss.copy(), state.detections
    baseline, baseline_s, filtered = state.baseline, state.baseline_s, state.filtered
    thrust, mean = advance(monitor.lag, state.thrust, command)
    thrusts = np.concatenate((state.delayed_thrust, mean.reshape(1, k)))
    total, delayed = state.waited_thrust + thrusts[0], thrusts[1:]
    mean = total / waited
    if sample.is_valid and last.is_valid:
        signatures, residual = residual_wrench(monitor, last, sample, mean, dt)
        residual -= baseline
        gains = monitor.filter_gains[int(waited) - 1]
        filtered = filtered + gains * (np.concatenate((residual, mean)) - filtered)

        rotor, lost, fit = isolate(monitor, signatures, filtered[FAST], loss)
        change = abs(lost - loss[rotor]) if fit > FAST_FIT else 0.0
        is_detected = change > FAST_LOSS
        count = detections[rotor] + 1.0 if is_detected else 0.0
        detections = np.zeros(k)
        detections[rotor] = count
        if count >= FAST_SAMPLES or (loss[rotor] > FAST_LOSS and change > FAST_CHANGE):
            is_detected = True
            loss[rotor] = lost
            filtered[SLOW] = filtered[FAST]  # The slow filter still contains the time before.
        if not is_detected:
            rotor, lost, fit = isolate(monitor, signatures, filtered[SLOW], loss)
            # Rotors that differ from each other from the start are absorbed by the baseline.
            least = SLOW_CHANGE if loss[rotor] > 0 else SLOW_LOSS * BASELINE_S / baseline_s
            is_detected = fit > SLOW_FIT and abs(lost - loss[rotor]) > least
            if is_detected:
                loss[rotor] = lost if lost > SLOW_LOSS / 2 else 0.0
        if not is_detected:
            baseline = baseline + dt / baseline_s * (residual - (mean * loss) @ signatures)
            baseline_s = min(baseline_s + dt, BASELINE_S)
    if sample.is_valid or waited >= len(monitor.filter_gains):
        last, waited, total = sample, 0.0, np.zeros(k)
    return RotorMonitorState(
        baseline, filtered, thrust, delayed, loss, detections, last, baseline_s, waited, total
    )


@compiled
def residual_wrench(
    monitor: RotorMonitor,
    last: MomentumSample,
    sample: MomentumSample,
    thrust: np.ndarray,
    dt: float,
) -> tuple[np.ndarray, np.ndarray]:
    """Returns the fault signatures per N of thrust lost, and the residual, in the base frame.

    Args:
        monitor: Its constants.
        last, sample: The sample before and this one.
        thrust: (k,) N, estimated mean thrusts between the two.
        dt: s, time between them.

    Returns:
        (k, 6) and (6,): torque about the centre of mass over `lever`, and force, in N.
    """
    R = (rotation_matrix(last.quaternion) + rotation_matrix(sample.quaternion)) / 2
    change = (sample.momentum - last.momentum) / dt
    change[5] += monitor.mass * GRAVITY
    r_BC = R.T @ ((last.r_BC + sample.r_BC) / 2)
    signatures, wrench = np.zeros((len(thrust), 6)), np.empty(6)
    wrench[:3] = R.T @ change[:3] / monitor.lever
    wrench[3:] = R.T @ change[3:]
    for i in range(len(thrust)):
        signatures[i, 0] = (r_BC[1] - monitor.p_B[i, 1]) / monitor.lever
        signatures[i, 1] = (monitor.p_B[i, 0] - r_BC[0]) / monitor.lever
        signatures[i, 2] = -monitor.drag[i] / monitor.lever
        signatures[i, 5] = -1.0
    return signatures, wrench + thrust @ signatures


@compiled
def isolate(
    monitor: RotorMonitor, signatures: np.ndarray, filtered: np.ndarray, loss: np.ndarray
) -> tuple[int, float, float]:
    """Returns the rotor whose loss explains a residual best, that loss, and its goodness of fit.

    Args:
        monitor: Its constants.
        signatures: (k, 6) fault signatures per N of thrust lost.
        filtered: (6 + k,) N, residual beyond the baseline, and estimated thrusts.
        loss: (k,) reported losses; those of the other rotors are subtracted first.
    """
    residual, signatures = filtered[:6], signatures * filtered[6:].reshape(len(loss), 1)
    rotor, best_loss, least = 0, 0.0, 1.0
    load = LEAST_LOAD * monitor.mass * GRAVITY / len(loss)
    unreported = residual - loss @ signatures
    for i in range(len(loss)):
        g = signatures[i]
        if -g[5] < load:
            continue
        own = unreported + loss[i] * g
        product = g[:3] @ own[:3] + FORCE_WEIGHT * (g[3:] @ own[3:])
        size = g[:3] @ g[:3] + FORCE_WEIGHT * (g[3:] @ g[3:])
        fraction = min(max(product / size, 0.0), 1.0)
        left = own - fraction * g
        # After a recovery the residual is near zero; the reported loss is the scale then.
        scale = max(own @ own, loss[i] ** 2 * (g @ g))
        if left @ left < least * scale:
            rotor, best_loss, least = i, fraction, (left @ left) / scale
    return rotor, best_loss, 1.0 - least
