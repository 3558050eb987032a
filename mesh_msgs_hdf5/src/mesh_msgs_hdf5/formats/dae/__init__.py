"""COLLADA, through assimp."""
