"""The coordinator in a process of its own, connected over LCM."""
