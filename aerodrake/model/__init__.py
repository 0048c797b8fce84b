"""Equations, without systems."""
