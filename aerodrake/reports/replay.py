"""A recording of a flight that plays in a browser, offline."""

import numpy as np

from aerodrake.flight.log import FlightLog
from aerodrake.reports.scene import Scene
from aerodrake.scenario import Scenario

FRAMES_PER_S = 30.0
MOST_FRAMES = 1800
"""Largest number of frames; longer recordings have fewer frames per second."""
MOST_POINTS = 6000
"""Largest number of points of a path."""


def replay_page(log: FlightLog, scenario: Scenario) -> str:
    """Returns a self-contained HTML page with the vehicle, its reference and its trace.

    Args:
        log: The log of the flight. The animation begins at reference time 0, or at the end of
            the flight if that is earlier.
        scenario: The scenario of the flight, for its payload.
    """
    time_s, parts = log.time_s, ("quaternion", "p_B_m", "q_rad")
    finite = np.all([np.isfinite(log[part]).all(axis=1) for part in parts], axis=0)
    end = time_s[finite][-1]
    flown = np.flatnonzero(finite & (time_s >= min(0.0, end)))
    stride = -(-len(flown) // MOST_POINTS)
    shown = flown[(len(flown) - 1) % stride :: stride]
    pace = min(FRAMES_PER_S, MOST_FRAMES / max(end, 1.0))
    times = np.arange(0.0, max(end, 0.0) + 1e-9, 1 / pace)
    rows = flown[np.minimum(np.searchsorted(time_s[flown], times - 1e-9), len(flown) - 1)]
    positions = np.hstack([log[part][rows] for part in parts])
    with Scene(scenario, log.vehicle) as scene:
        scene.draw_reference(log["p_Ed_m"][shown])
        scene.draw_trace(log["p_E_m"][shown])
        scene.look_at(log["p_B_m"][flown].mean(axis=0))
        scene.meshcat.StartRecording(frames_per_second=pace)
        for time, position in zip(times, positions, strict=True):
            scene.pose(time, position)
        scene.meshcat.StopRecording()
        scene.meshcat.PublishRecording()
        return scene.meshcat.StaticHtml()
