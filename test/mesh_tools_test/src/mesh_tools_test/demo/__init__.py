"""The main job, from a mesh file to a picture of RViz with a planned path."""
