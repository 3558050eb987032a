"""What is in the map file of a mesh, on a mesh that was derived of it."""

from typing import Any, Dict, Iterable, Optional

import numpy as np
from mesh_msgs.derived_mesh import DerivedMesh
from mesh_msgs_hdf5.model.carried_mesh import carried_label, carried_mesh
from mesh_msgs_hdf5.model.mesh import Label, Mesh


class DerivedContents:
    """The reading interface of the parent's contents, with arrays that fit the derived mesh.

    Labels, stored layers and attributes stay those of the parent; they are read, and carried over,
    when they are asked for.

    Attributes:
        derived: the derived mesh.
        parent: MapContents of the parent.
    """

    def __init__(self, parent: Any, derived: DerivedMesh) -> None:
        self.parent, self.derived = parent, derived
        self.uuid = derived.uuid
        self.vertex_count, self.face_count = len(derived.vertices), len(derived.faces)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_") or name == "parent":
            raise AttributeError(name)
        return getattr(self.parent, name)

    def vertex_costs(self, name: str) -> np.ndarray:
        """(V,) float32 of a stored layer, see DerivedMesh.vertex_values()."""
        return self.derived.vertex_values(self.parent.vertex_costs(name))

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
        """The derived mesh with these members of the parent."""
        return carried_mesh(self.parent.read(members), self.derived)
