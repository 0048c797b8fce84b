"""Random reference sections, as strategies of hypothesis."""

from pathlib import Path

import numpy as np
from hypothesis import settings
from hypothesis import strategies as st

from aerodrake.scenario import (
    Clover,
    FigureEight,
    Hover,
    Lissajous,
    MovingTarget,
    Waypoints,
)

START = np.array([0.0, 0.2, 1.2])
CSV = Path(__file__).parents[3] / "aerodrake" / "scenarios" / "waypoints.csv"

lengths = st.floats(0.05, 2.0)
laps = st.floats(2.0, 60.0)
starts = st.floats(0.5, 5.0)
angles = st.floats(-1.5, 1.5)


def triples(element):
    return st.tuples(element, element, element)


clovers = st.builds(Clover, amplitude_m=lengths, lap_s=laps, start_s=starts)
eights = st.builds(
    FigureEight, length_m=lengths, width_m=lengths, tilt_rad=angles, lap_s=laps, start_s=starts
)
lissajous = st.builds(
    Lissajous,
    amplitude_m=triples(st.just(0.0) | lengths),
    period_s=triples(st.sampled_from([4.0, 6.0, 7.5, 8.0, 12.0])),
    phase_rad=triples(angles),
    start_s=starts,
)
closed = clovers | eights | lissajous
targets = st.builds(MovingTarget, velocity_m_s=triples(st.floats(-1, 1)))
curves = closed | targets | st.just(Hover()) | st.just(Waypoints(str(CSV)))

quick = settings(max_examples=30, deadline=None)
