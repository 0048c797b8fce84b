"""Quadratic programs, independent of the MPC."""
