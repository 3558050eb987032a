"""What generated meshes are made of, above all those of the outdoor world."""
