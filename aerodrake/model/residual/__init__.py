"""The residual network (paper, section II-C), its online learning, and its training."""
