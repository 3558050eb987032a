"""What differs between two meshes."""
