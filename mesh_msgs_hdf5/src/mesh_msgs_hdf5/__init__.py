"""The map file of annotated triangle meshes: safe reading and saving, import of other formats.
"""

# that of package.xml
__version__ = "0.1.0"
