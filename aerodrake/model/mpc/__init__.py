"""MPC (paper, section III): cost, condensing, weight allocation; CLIK as its baseline."""
