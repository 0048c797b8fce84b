"""Setpoints from u by double integration."""
