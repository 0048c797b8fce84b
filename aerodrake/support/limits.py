"""Ranges of arguments, for the command line and the functions behind it."""

JOBS = 1, 1000
"""Number of concurrent processes."""

TRIALS = 1, 100_000
"""Number of flights of a sweep."""

DEPTH = 0, 100
"""Number of levels of diagrams to open."""

RATE = 0.01, 1000.0
"""Ratio of simulated time to wall time."""

SEED = 0, 2**31 - 1
"""Seed of random numbers."""

REFERENCE_TIME = -60.0, 3600.0
"""s, time from the start of the reference, negative in the hover before."""
