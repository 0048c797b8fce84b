"""One scenario flown many times: Monte Carlo and grids, on processes or a cluster."""
