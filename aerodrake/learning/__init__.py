"""The residual network's way from flights to a checkpoint, and how good it is."""
