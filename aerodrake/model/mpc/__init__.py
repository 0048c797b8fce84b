"""MPC (paper, section III): problem, condensed program, weight allocation; CLIK as its baseline."""
