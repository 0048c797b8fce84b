"""Version of the package."""

__version__ = "0.1.0"
"""The only place of the version: the built package has it from here."""
