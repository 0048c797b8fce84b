"""LeafSystems, one per file, named as in the graph."""
