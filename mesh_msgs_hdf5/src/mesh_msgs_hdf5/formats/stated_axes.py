"""Which axis a file says to be up: its reader applies that, so that its mesh has z up."""
import re

from mesh_msgs_hdf5.formats.dae.fbx_settings import up_axis
from mesh_msgs_hdf5.formats.dae.zae_archive import document_head

_UP_AXIS = re.compile(rb"<up_axis>\s*([XYZ])_UP\s*</up_axis>")


def stated_up(kind: str, data: bytes) -> str:
    """One of x, y and z for a file of a kind (as in importer.FORMATS); "" if it says none."""
    if kind in ("glb", "gltf"):
        return "y"
    if kind == "3ds":
        return "z"
    if kind == "fbx":
        return up_axis(data)
    if kind not in ("dae", "zae"):
        return ""
    found = _UP_AXIS.search(document_head(data) if kind == "zae" else data)
    return found[1].decode().lower() if found else "y"
