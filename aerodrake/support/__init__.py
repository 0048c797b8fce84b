"""Errors, files, processes, interrupts, timing and compiled code, independent of scenarios."""
