"""Reads which vertices of a part are copies along the seams of textures."""
from typing import List, Optional

import numpy as np

from mesh_msgs_hdf5.checks.check import checked_seams
from mesh_msgs_hdf5.map_file.hdf5.hdf5_attributes import text_attribute
from mesh_msgs_hdf5.map_file.hdf5.hdf5_guard import exists
from mesh_msgs_hdf5.map_file.reading.part_reader import PartReader
from mesh_msgs_hdf5.model import schema
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.mesh import Mesh


_WAY_OUT = "mesh_tool repair restores the table, import --merge-vertices makes it anew"


class SeamReader(PartReader):
    """The table of copies of a part, which a file of before has not."""

    vertices: np.ndarray
    faces: np.ndarray
    # a table of another mesh is taken where every copy lies on its original, with a note
    restores_seams = False

    def seam_places(self) -> List[str]:
        """Where the table is; [] if there is none."""
        place = "%s/%s" % (self.layout.seams, schema.ORIGINALS)
        return [place] if self.has_seams and exists(self.guarded.group, place) else []

    @property
    def has_seams(self) -> bool:
        """True if something is where the table of copies is."""
        return bool(self.layout.seams) and exists(self.guarded.group, self.layout.seams)

    @property
    def seam_originals(self) -> Optional[np.ndarray]:
        """(C,) uint32, see Mesh; None if the file has none that can be read."""
        return self.originals_of(self.vertices, self.faces) if self.has_seams else None

    @property
    def parent_uuid(self) -> str:
        """The UUID of the mesh without the copies; "" if there are none."""
        originals = self.seam_originals
        if originals is None:
            return ""
        return Mesh(self.vertices, self.faces, seam_originals=originals).parent_uuid

    def originals_of(self, vertices: np.ndarray, faces: np.ndarray) -> Optional[np.ndarray]:
        """seam_originals of a geometry that was read already."""
        if not self.seam_places():
            return None
        return self.tolerated(lambda: self._originals(vertices, faces), None)

    def _originals(self, vertices, faces):
        path = self.guarded.path
        found = self.guarded.dataset(self.seam_places()[0])
        mesh = Mesh(vertices, faces, seam_originals=self.guarded.values(found))
        mesh.seam_originals = checked_seams(path, mesh)
        stored, actual = text_attribute(path, found, schema.PARENT_UUID), mesh.parent_uuid
        if stored != actual:
            text = "%s is of the mesh %s, but without the copies this one is %s"
            text += ", though every copy lies on its original"
            text %= found.name, stored, actual
            if not self.restores_seams:
                # the error itself has no place for a hint where it becomes a note
                text += "; " + _WAY_OUT if not self.strict else ""
                raise MapFileError("uuid", path, text, _WAY_OUT)
            self.note("restored: " + text)
        return mesh.seam_originals
