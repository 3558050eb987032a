"""What is in a part by name, to see that nothing was lost or gained."""
from dataclasses import dataclass, fields, replace
from typing import FrozenSet

from mesh_msgs_hdf5.map_file.reading.map_reader import MapReader
from mesh_msgs_hdf5.model.edit import Edit
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.mesh import Mesh


@dataclass(frozen=True)
class PartNames:
    """The members of a part that have names, and its sizes."""

    vertex_count: int
    face_count: int
    layers: FrozenSet[str]
    vertex_attributes: FrozenSet[str]
    face_attributes: FrozenSet[str]
    labels: FrozenSet[str]
    textures: FrozenSet[int]
    normals: bool
    colors: bool
    seams: bool

    @classmethod
    def of_mesh(cls, mesh: Mesh) -> "PartNames":
        """Those of a Mesh."""
        return cls(
            vertex_count=len(mesh.vertices),
            face_count=len(mesh.faces),
            layers=frozenset(mesh.vertex_costs),
            vertex_attributes=frozenset(mesh.vertex_attributes),
            face_attributes=frozenset(mesh.face_attributes),
            labels=frozenset(mesh.labels),
            textures=frozenset(mesh.textures),
            normals=mesh.vertex_normals is not None,
            colors=mesh.vertex_colors is not None,
            seams=mesh.seam_originals is not None,
        )

    @classmethod
    def of_reader(cls, reader: MapReader) -> "PartNames":
        """Those that a reader sees in a file: what has the rows of another mesh is none, for a file
        of others that becomes one of ours may have such numbers.
        """
        return cls(
            vertex_count=reader.vertex_count,
            face_count=reader.face_count,
            layers=frozenset(reader.with_rows(reader.layer_names())),
            vertex_attributes=frozenset(reader.with_rows(reader.vertex_attribute_names())),
            face_attributes=frozenset(reader.face_attribute_names()),
            labels=_labels(reader),
            textures=frozenset(reader.texture_indices()),
            normals=reader.has_normals,
            colors=reader.has_colors,
            seams=bool(reader.seam_places()),
        )

    def edited(self, edit: Edit) -> "PartNames":
        """Those after an edit."""
        return replace(
            self,
            layers=_edited(self.layers, edit.vertex_costs),
            vertex_attributes=_edited(self.vertex_attributes, edit.vertex_attributes),
            face_attributes=_edited(self.face_attributes, edit.face_attributes),
            labels=_edited(self.labels, edit.labels),
            textures=_edited(self.textures, edit.textures),
            normals=_is_there(self.normals, edit, "vertex_normals"),
            colors=_is_there(self.colors, edit, "vertex_colors"),
        )

    def first_difference(self, other: "PartNames") -> str:
        """The name of the first member that differs."""
        return next(
            field.name
            for field in fields(self)
            if getattr(self, field.name) != getattr(other, field.name)
        )


def _labels(reader):
    """The names, or what is wrong with them: others are saved all the same, for labels are carried
    over as they are stored, and compared so."""
    try:
        return frozenset(reader.label_names())
    except MapFileError as error:
        if error.code != "label":
            raise
        return frozenset([str(error)])


def _edited(names, changes):
    added = {name for name, value in changes.items() if value is not None}
    return (names - frozenset(changes)) | added


def _is_there(before, edit, name):
    return name not in edit.remove and (before or getattr(edit, name) is not None)
