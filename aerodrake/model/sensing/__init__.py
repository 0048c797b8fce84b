"""Samples: their noise, their checks, and the Kalman filters that use them."""
