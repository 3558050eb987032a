"""The map file of Mesh Tools: safe reading and saving of triangle meshes with attributes, import
from other formats.
"""
