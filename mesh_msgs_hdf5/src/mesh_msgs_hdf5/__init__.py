"""The map file of annotated triangle meshes: safe reading and saving, import of other formats.
"""
