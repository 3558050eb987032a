"""The map file of annotated triangle meshes: safe reading and saving, import of other formats.
"""
from mesh_msgs.module_aliases import alias_modules

# that of package.xml
__version__ = "0.1.0"

# names of the time before there were rooms, as READMEs have had them
_MOVED = {
    "confine": "files.confine",
    "convert": "map_file.convert",
    "edit": "model.edit",
    "exporter": "formats.exporter",
    "importer": "formats.importer",
    "mesh": "model.mesh",
}
alias_modules({"%s.%s" % (__name__, old): "%s.%s" % (__name__, _MOVED[old]) for old in _MOVED})
