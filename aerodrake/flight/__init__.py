"""One flight: simulated, monitored, recorded and summarised."""
