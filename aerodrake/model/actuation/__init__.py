"""Actuation: friction, backlash and flexibility of joints, and messages with setpoints."""
