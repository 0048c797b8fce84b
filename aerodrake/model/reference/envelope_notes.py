"""Notes on a reference that leaves the envelope, before it is flown."""

from collections.abc import Iterator

import numpy as np

from aerodrake.model.reference.curves import make_reference
from aerodrake.model.reference.envelope import Envelope, ReferenceVerdict, check_points
from aerodrake.model.reference.reference_curve import Motion
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Scenario
from aerodrake.support.errors import file_at

SIZE_KEYS = {
    "hover": "the vehicle's initial position",
    "clover": "reference.amplitude_m",
    "figure_eight": "reference.length_m, width_m or tilt_rad",
    "lissajous": "reference.amplitude_m",
    "moving_target": "reference.target_m, velocity_m_s or height_m",
    "waypoints": "reference.file",
}
"""Keys that determine where a reference is, by its kind."""

SPEED_KEYS = {
    "clover": "reference.amplitude_m or lap_s",
    "figure_eight": "reference.length_m, width_m or lap_s",
    "lissajous": "reference.amplitude_m or period_s",
    "moving_target": "reference.velocity_m_s",
    "waypoints": "reference.file",
}
"""Keys that determine how fast a reference is, by its kind."""


def envelope_notes(scenario: Scenario, vehicle: VehicleModel) -> list[str]:
    """Returns a note for each limit of the envelope that the scenario's reference violates.

    The reference is sampled at the ticks of the MPC.

    Raises:
        BadInput: if a file of the scenario cannot be used.
    """
    with file_at(scenario.source, "reference.file"):
        curve = make_reference(scenario.reference, vehicle.p_E)
    period = scenario.rates.mpc_period_s
    times = period * np.arange(int(scenario.duration / period + 1e-9) + 1)
    envelope = Envelope.make(scenario.supervisor, vehicle.p_E)
    notes = []
    for violation, is_violated in _violations(envelope, curve.evaluate(times), scenario):
        refused = np.flatnonzero(is_violated)
        if len(refused):
            span = "all the time"
            if len(refused) < len(times):
                seconds = period * len(refused)
                span = f"from {times[refused[0]]:.2f} s on, for {seconds:.2f} s in all"
            notes.append(f"{violation}, {span}; meanwhile it is not followed and the vehicle holds")
    return notes


def _violations(
    envelope: Envelope, motion: Motion, scenario: Scenario
) -> Iterator[tuple[str, np.ndarray]]:
    """Yields a clause on each limit, and the samples (T,) that violate it: True or False."""
    p, v = motion
    verdicts = check_points(envelope, np.hstack(motion))
    is_outside, is_low = verdicts == ReferenceVerdict.OUT_OF_REACH, p[:, 2] < envelope.lowest
    kind = scenario.reference.kind
    size, speed = SIZE_KEYS[kind], SPEED_KEYS.get(kind, "")
    distance = np.linalg.norm(p - envelope.start, axis=1)
    yield (
        f"{size}: the reference is too low ({p[:, 2].min():.4g} m), below supervisor.lowest_m "
        f"({envelope.lowest:g} m)",
        is_outside & is_low,
    )
    yield (
        f"{size}: the reference is too far ({distance.max():.4g} m from the start), above "
        f"supervisor.farthest_m ({envelope.farthest:g} m)",
        is_outside & ~is_low,
    )
    yield (
        f"{speed}: the reference is too fast ({np.abs(v).max():.4g} m/s along an axis), above "
        f"supervisor.fastest_m_s ({envelope.fastest:g} m/s)",
        verdicts == ReferenceVerdict.TOO_FAST,
    )
