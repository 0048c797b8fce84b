"""Equivalent kinematic models of base and arm: states, prediction, identification."""
