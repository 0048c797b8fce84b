"""The equivalent model x+ = A x + B u + C Delta (paper, section II-B), and fitting K_B."""
