"""COLLADA, FBX and 3DS: read through assimp; COLLADA: written."""
