"""Variants of one flight, and its margins."""
