"""Setpoints: double integration of u, braking, and prescribed motions."""
