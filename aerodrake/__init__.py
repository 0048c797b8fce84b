"""Predictive kinematic control of aerial manipulators as a Drake diagram."""
