"""COLLADA, through assimp in a process of its own."""
