"""What an import did: counts, and a line for each thing that is not as it was in the file."""
from dataclasses import dataclass, field
from typing import List

import numpy as np

from mesh_msgs.text import one_line
from mesh_msgs_hdf5.model.mesh import Mesh

_ROUNDED = 1e-5  # meters: what one could notice
_FAR = 1e-3  # meters: what one should do something about


@dataclass
class ImportReport:
    """Counts and notes; nothing is changed without a note.

    format: "PLY", "OBJ", "STL", "OFF", "DAE", "ZAE", "FBX", "3DS", "GLB", "glTF" or "HDF5";
    vertices, faces, layers, vertex_attributes, face_attributes, materials, textures, labels: of
    the mesh; triangulated: polygons of more than three corners in the file; merged: vertices that
    fell together; split: copies of vertices appended along seams; dropped_vertices, dropped_faces,
    flipped: what repairing did; rounded: by how much (meters) a coordinate changed at most by
    becoming float32.
    """

    path: str
    format: str
    vertices: int = 0
    faces: int = 0
    layers: int = 0
    vertex_attributes: int = 0
    face_attributes: int = 0
    materials: int = 0
    textures: int = 0
    labels: int = 0
    triangulated: int = 0
    merged: int = 0
    split: int = 0
    dropped_vertices: int = 0
    dropped_faces: int = 0
    flipped: int = 0
    rounded: float = 0.0
    notes: List[str] = field(default_factory=list)

    def note(self, text: str, *values) -> None:
        """Add a sentence; values are put into it by %."""
        self.notes.append(text % values if values else text)

    def count(self, mesh: Mesh) -> None:
        """Take the counts of the mesh."""
        self.vertices, self.faces = len(mesh.vertices), len(mesh.faces)
        self.layers, self.face_attributes = len(mesh.vertex_costs), len(mesh.face_attributes)
        self.vertex_attributes = len(mesh.vertex_attributes)
        self.materials = 0 if mesh.materials is None else len(mesh.materials.colors)
        self.textures, self.labels = len(mesh.textures), len(mesh.labels)

    def lines(self) -> List[str]:
        """The report for a person."""
        head = "%s: %s, %d vertices, %d faces" % (
            self.path,
            self.format,
            self.vertices,
            self.faces,
        )
        names = (
            "layers",
            "vertex_attributes",
            "face_attributes",
            "materials",
            "textures",
            "labels",
        )
        for name in names:
            count, noun = getattr(self, name), name.replace("_", " ")
            if count:
                head += ", %d %s" % (count, noun if count != 1 else noun[:-1])
        return [one_line(head)] + ["  note: " + one_line(note) for note in self.notes]


def note_costs(report: ImportReport, name: str, costs: np.ndarray) -> None:
    """Say what a layer has that is no cost: negative values, and values that are not finite."""
    negative = np.flatnonzero(costs < 0)
    if len(negative):
        report.note(
            "layer %s has %d negative values, first %g at vertex %d; costs are >= 0",
            name,
            len(negative),
            costs[negative[0]],
            negative[0],
        )
    unknown, lethal = np.count_nonzero(np.isnan(costs)), np.count_nonzero(costs == np.inf)
    if unknown or lethal:
        report.note("layer %s has %d unknown (NaN), %d lethal (inf) values", name, unknown, lethal)


def is_noticed(change: float) -> bool:
    """True for a change of coordinates, in meters, that one could notice."""
    return change > _ROUNDED


def note_rounding(report: ImportReport, change: float) -> None:
    """Say how much coordinates changed by becoming float32, where one could notice (0.01 mm)."""
    if is_noticed(change):
        report.rounded = change
        report.note(
            "coordinates were rounded to float32, by at most %.3g m (far from the origin?)%s",
            change,
            "; --origin auto keeps them" if change > _FAR else "",
        )
