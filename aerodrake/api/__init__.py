"""The functions behind `import aerodrake`: flight, analysis, comparison, sweep, ..."""
