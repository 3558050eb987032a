"""The labels of a mesh on one that was derived of it: seen there, and edited for the parent."""

from typing import Any, Dict, List, Optional

import numpy as np
from mesh_msgs.derived_mesh import DerivedMesh
from mesh_msgs_hdf5.labels.journal_reading import OwnedError
from mesh_msgs_hdf5.labels.label_store import LabelStore
from mesh_msgs_hdf5.model.carried_mesh import carried_label
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.mesh import Color, Label


class DerivedLabels:
    """The labels of the parent's map file, with the edits of its journal, on the derived mesh.

    They are never stored here: whoever owns the labels of the parent does that, so what would
    change them raises OwnedError.

    Attributes:
        parent: LabelStore of the parent, which only reads.
        derived: the mesh.
    """

    def __init__(self, parent: LabelStore, derived: DerivedMesh) -> None:
        self.parent, self.derived = parent, derived

    path = property(lambda self: self.parent.path)
    uuid = property(
        lambda self: self.parent.uuid, doc="Of the parent, by which its owner knows it."
    )

    @property
    def owner(self) -> Optional[Dict[str, Any]]:
        """What is known of the process that owns the labels; None if there is none."""
        return self.parent.owner

    @property
    def refusal(self) -> MapFileError:
        """Why labels cannot be changed while they have no owner."""
        return MapFileError(
            "owned",
            self.path,
            "nobody stores its labels",
            "rosrun mesh_msgs_hdf5 hdf5_map_server %s" % self.path,
        )

    def names(self) -> List[str]:
        """The texts of all labels, tree_2 before tree_10."""
        return self.parent.names()

    def get(self, text: str) -> Label:
        """A label. Raises MapFileError (label) if there is none."""
        return carried_label(self.parent.get(text), self.derived)

    def all(self) -> Dict[str, Label]:
        """Text -> label, in the order of names()."""
        return self._carried(self.parent.all())

    def groups(self) -> List[str]:
        """The classes of all labels."""
        return self.parent.groups()

    def group(self, class_name: str) -> Dict[str, Label]:
        """The labels of exactly that class."""
        return self._carried(self.parent.group(class_name))

    def edited(self, text: str, faces: Any, override: bool) -> np.ndarray:
        """(M,) uint32: the parent's faces for an edit of a label, see edited_parent_faces().

        Args:
            text: of the label.
            faces: (K,) of the derived mesh.
            override: they replace those of the label; False: they are added to them.
        Raises:
            ValueError: a face that the mesh does not have.
        """
        before: Any = ()
        if override and text in self.parent.names():
            before = self.parent.get(text).faces
        return self.derived.edited_parent_faces(faces, before)

    def delete(self, text: str) -> Label:
        """Only its owner does that. Raises MapFileError (owned, or label if there is none)."""
        self.parent.get(text)
        raise OwnedError(self.path, self.owner)

    def set_color(self, text: str, color: Optional[Color]) -> Label:
        """Only its owner does that. Raises MapFileError (owned, or label if there is none)."""
        self.parent.get(text)
        raise OwnedError(self.path, self.owner)

    def _carried(self, labels: Dict[str, Label]) -> Dict[str, Label]:
        return {text: carried_label(label, self.derived) for text, label in labels.items()}
