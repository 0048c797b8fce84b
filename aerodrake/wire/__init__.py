"""The coordinator in a separate process, connected over LCM."""
