"""Identification of K_B from simulated flights."""
