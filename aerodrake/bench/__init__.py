"""Benchmarks of the MPC tick, the closed loop, scaling, memory and start-up."""
