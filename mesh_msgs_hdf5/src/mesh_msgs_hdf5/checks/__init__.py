"""The values of meshes and edits, checked when they enter."""
