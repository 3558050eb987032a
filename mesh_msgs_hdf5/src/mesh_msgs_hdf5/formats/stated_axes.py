"""Which axis a file says to be up: its reader applies that, so that its mesh has z up."""
import re

_UP_AXIS = re.compile(rb"<up_axis>\s*([XYZ])_UP\s*</up_axis>")
_FIXED = {"glb": "y", "gltf": "y", "3ds": "z"}


def stated_up(kind: str, data: bytes) -> str:
    """One of x, y and z for a file of a kind (as in importer.FORMATS); "" if it says none."""
    # what reads a format is imported with the first file of it
    if kind == "fbx":
        from mesh_msgs_hdf5.formats.dae.fbx_settings import up_axis

        return up_axis(data)
    if kind == "zae":
        from mesh_msgs_hdf5.formats.dae.zae_archive import document_head

        data = document_head(data)
    if kind in ("dae", "zae"):
        found = _UP_AXIS.search(data)
        return found[1].decode().lower() if found else "y"
    return _FIXED.get(kind, "")
