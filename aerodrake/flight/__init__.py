"""Simulation, monitoring, recording and summary of one flight."""
