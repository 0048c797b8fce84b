"""A recording of a flight that plays in a browser, offline."""

import numpy as np

from aerodrake.flight.log import FlightLog
from aerodrake.reports.drawable import drawable
from aerodrake.reports.scene import Scene
from aerodrake.scenario import Scenario

FRAMES_PER_S = 30.0
MOST_FRAMES = 1800
"""Largest number of frames; longer recordings have fewer frames per second."""
MOST_POINTS = 6000
"""Largest number of points of a path."""
LEAST_NORM = 1e-3
"""Smallest norm of a quaternion."""
BASE = slice(4, 7)
"""Position of the base among the positions of the plant."""


def replay_page(log: FlightLog, scenario: Scenario) -> str:
    """Returns a self-contained HTML page with the vehicle, its reference and its trace.

    States that cannot be shown, since they are not finite or diverged, are left out; of a flight
    without any other, the page has the vehicle at its start.

    Args:
        log: The log of the flight. The animation begins at reference time 0, or at the end of
            the flight if that is earlier.
        scenario: The scenario of the flight, for its payload.
    """
    log = drawable(log)
    times, positions = replay_frames(log)
    flown = np.flatnonzero(log.time_s >= min(0.0, log.time_s[-1]))
    stride = -(-len(flown) // MOST_POINTS)
    shown = flown[(len(flown) - 1) % stride :: stride]
    with Scene(scenario, log.vehicle) as scene:
        scene.draw_reference(finite_points(log["p_Ed_m"][shown]))
        scene.draw_trace(finite_points(log["p_E_m"][shown]))
        scene.look_at(np.median(positions[:, BASE], axis=0))
        scene.meshcat.StartRecording(frames_per_second=_pace(times[-1]))
        for time, position in zip(times, positions, strict=True):
            scene.pose(time, position)
        scene.meshcat.StopRecording()
        scene.meshcat.PublishRecording()
        return scene.meshcat.StaticHtml()


def replay_frames(log: FlightLog) -> tuple[np.ndarray, np.ndarray]:
    """Returns the times (F,) s of the frames, and the positions (F, 7 + n) of the plant there."""
    time_s = log.time_s
    positions = np.hstack([log["quaternion"], log["p_B_m"], log["q_rad"]])
    finite = np.isfinite(positions).all(axis=1)
    # Drake normalises quaternions, which is not possible near zero.
    finite &= np.linalg.norm(log["quaternion"], axis=1) > LEAST_NORM
    if not finite.any():
        return np.zeros(1), log.vehicle.trim_state[None, : positions.shape[1]]
    end = time_s[finite][-1]
    flown = np.flatnonzero(finite & (time_s >= min(0.0, end)))
    times = np.arange(0.0, max(end, 0.0) + 1e-9, 1 / _pace(end))
    rows = flown[np.minimum(np.searchsorted(time_s[flown], times - 1e-9), len(flown) - 1)]
    return times, positions[rows]


def _pace(end_s: float) -> float:
    """Returns the frames per second of a flight up to a reference time."""
    return min(FRAMES_PER_S, MOST_FRAMES / max(end_s, 1.0))


def finite_points(points: np.ndarray) -> np.ndarray:
    """Returns the points (K, 3) of (T, 3) that are finite."""
    return points[np.isfinite(points).all(axis=1)]
