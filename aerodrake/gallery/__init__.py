"""Graphs and pages of diagrams and systems."""
