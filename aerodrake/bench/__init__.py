"""Benchmarks: MPC tick, closed loop, scaling."""
