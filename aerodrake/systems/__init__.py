"""LeafSystems, one a file, named as in the graph."""
