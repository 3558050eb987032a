"""Wavefront OBJ with its MTL files."""
