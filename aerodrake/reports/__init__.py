"""The table, figures, page and replay of one flight."""
