"""Many flights of varied scenarios."""
