"""Sub-diagrams that the station and the coordinator consist of."""
