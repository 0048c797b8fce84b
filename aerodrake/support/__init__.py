"""Errors, files, processes, interrupts and compiled code, independent of scenarios."""
