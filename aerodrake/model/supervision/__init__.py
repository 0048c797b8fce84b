"""Fault detection and safe modes."""
