"""Training of the residual network."""
