"""Option to run the coordinator in a process of its own, connected over LCM."""
