"""A cost layer for mesh_map in a package of its own."""
