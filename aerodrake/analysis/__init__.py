"""Analysis of the sampled closed loop as a linear system."""
