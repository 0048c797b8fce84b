"""The functions behind `import aerodrake`: one flight, a comparison, a sweep, an identification."""
