"""MPC (paper, section III): objective, bounds, program, weight allocation; CLIK as its baseline."""
