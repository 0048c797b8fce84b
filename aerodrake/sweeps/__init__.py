"""Many flights of a scenario with varied keys."""
