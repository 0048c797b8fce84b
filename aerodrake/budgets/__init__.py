"""Error budget: what each flaw of sensors, actuators and environment costs."""
