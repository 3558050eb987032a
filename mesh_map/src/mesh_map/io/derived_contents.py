"""What is in the map file of a mesh, on one that was derived of it, or that it was derived of."""

from dataclasses import replace
from typing import Any, Dict, Iterable, Optional

import numpy as np
from mesh_msgs.derived_mesh import DerivedMesh
from mesh_msgs.split_mesh import SplitMesh
from mesh_msgs_hdf5.model.carried_mesh import carried_attribute, carried_label, carried_mesh
from mesh_msgs_hdf5.model.mesh import Label, Mesh


class WholeContents:
    """What is in the map file of a mesh with copies of vertices along the seams of textures, on the
    mesh without copies. Faces are the same, and so are labels.

    Attributes:
        split: the mesh of the file.
        parent: MapContents of that.
    """

    def __init__(self, parent: Any, split: SplitMesh) -> None:
        self.parent, self.split = parent, split
        self.vertex_count = split.parent_vertex_count

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_") or name == "parent":
            raise AttributeError(name)
        return getattr(self.parent, name)

    def vertex_costs(self, name: str) -> np.ndarray:
        """(V,) float32 of a stored layer; where copies differ the largest, and NaN before it."""
        return self.split.parent_vertex_values(self.parent.vertex_costs(name))

    def vertex_attribute(self, name: str) -> np.ndarray:
        """(V,) or (V, C): those of the originals."""
        return self.parent.vertex_attribute(name)[: self.vertex_count]

    def read(self, members: Optional[Iterable[str]] = None) -> Mesh:
        """The mesh with copies, as it is shown: textures need them."""
        return self.parent.read(members)


class DerivedContents:
    """The reading interface of the parent's contents, with arrays that fit the derived mesh.

    Labels, stored layers and attributes stay those of the parent; they are read, and carried over,
    when they are asked for.

    Attributes:
        derived: the derived mesh.
        parent: MapContents of the parent.
    """

    def __init__(
        self,
        parent: Any,
        derived: DerivedMesh,
        split: Optional[SplitMesh] = None,
        split_derived: Optional[DerivedMesh] = None,
    ) -> None:
        """
        Args:
            parent, derived: see above.
            split, split_derived: as MeshGeometry has them, where there are seams.
        """
        self.parent, self.derived = parent, derived
        self._split, self._split_derived = split, split_derived
        self.uuid = derived.uuid
        self.vertex_count, self.face_count = len(derived.vertices), len(derived.faces)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_") or name == "parent":
            raise AttributeError(name)
        return getattr(self.parent, name)

    def vertex_costs(self, name: str) -> np.ndarray:
        """(V,) float32 of a stored layer, see DerivedMesh.vertex_values()."""
        return self.derived.vertex_values(self.parent.vertex_costs(name))

    def vertex_attribute(self, name: str) -> np.ndarray:
        """(V,) or (V, C)."""
        return carried_attribute(self.parent.vertex_attribute(name), self.derived)

    def face_attribute(self, name: str) -> np.ndarray:
        """(F,) or (F, C)."""
        return self.derived.face_values(self.parent.face_attribute(name))

    def label(self, text: str) -> Label:
        """One label."""
        return carried_label(self.parent.label(text), self.derived)

    def labels(self) -> Dict[str, Label]:
        """Text -> label, of all."""
        return {
            text: carried_label(label, self.derived) for text, label in self.parent.labels().items()
        }

    def read(self, members: Optional[Iterable[str]] = None) -> Mesh:
        """The derived mesh with these members of the parent; with copies along the seams of its
        textures, as it is shown."""
        mesh = self.parent.read(members)
        if self._split is None or self._split_derived is None:
            return carried_mesh(mesh, self.derived)
        carried = carried_mesh(mesh, self._split_derived)
        return replace(carried, seam_originals=self._split.originals)
