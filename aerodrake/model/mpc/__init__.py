"""The MPC (paper, section III): cost, condensing, weight allocation; and CLIK, its alternative."""
