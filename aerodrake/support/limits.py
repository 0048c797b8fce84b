"""Ranges of arguments, for the command line and the functions behind it."""

JOBS = 1, 1000
"""Number of concurrent processes."""

TRIALS = 1, 100_000
"""Number of flights of a sweep."""

SEEDS = 1, 1000
"""Number of seeds of an error budget."""

DEPTH = 0, 100
"""Number of levels of diagrams to open."""

RATE = 0.01, 1000.0
"""Ratio of simulated time to wall time."""

SEED = 0, 2**31 - 1
"""Seed of random numbers."""

REFERENCE_TIME = 0.0, 3600.0
"""s, time from the start of the reference."""

SCALE = 1e-3, 1e3
"""Factors of an arm's lengths and masses."""

BASE_KG = 0.01, 1000.0
"""Mass of a multirotor's base."""

ROTORS = 4, 16
"""Number of a multirotor's rotors."""

ROTOR_RADIUS_M = 0.01, 10.0
"""Radius of the circle on which a multirotor's rotors are."""

THRUST_N = 0.1, 1000.0
"""Largest thrust of a rotor."""

POSE = -10.0, 10.0
"""Coordinates in m, and angles in rad, of the place where an arm is mounted."""
