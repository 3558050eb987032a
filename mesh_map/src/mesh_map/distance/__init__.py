"""Distances over the surface, as potentials, and the shortest paths that follow from them."""
