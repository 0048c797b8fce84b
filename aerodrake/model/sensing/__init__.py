"""Samples of the state: noise, faults, checks, and the Kalman filter."""
