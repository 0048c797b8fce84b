"""Equations that run at every sample, compiled to machine code."""

from __future__ import annotations

from numba import njit

compiled = njit(cache=True, error_model="numpy")
"""Compiles a function of arrays, numbers and named tuples of them; calls of others inline.

What a function of small vectors costs in numpy is the calls, not the arithmetic: compiled
it takes a tenth or less. The first run on a machine compiles, later ones read its cache.
Arithmetic is IEEE's, in the order as written, so that results repeat bit for bit; division
by zero gives inf or nan as in numpy. With NUMBA_DISABLE_JIT=1 in the environment the same
lines run as plain Python.
"""
