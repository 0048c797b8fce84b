"""Variants of one flight, and their robustness margins."""
