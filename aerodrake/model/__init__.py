"""Equations as plain functions and classes, independent of Drake's systems framework."""
