"""A change of a map file: what is to be added, replaced or removed; all else stays as it is."""
from dataclasses import dataclass, field, fields
from typing import Any, Dict, FrozenSet, Mapping, Optional, Tuple

import numpy as np

from mesh_msgs_hdf5.model.label_names import natural_order
from mesh_msgs_hdf5.model.mesh import Features, Label, Materials

LabelChanges = Dict[str, Optional[Label]]  # text -> label; None for one that is deleted


@dataclass
class CostsUpdate:
    """Some values of a layer in an Edit: where changed, (V,) bool, is False, the layer stays as it
    is in the file when it is saved; a layer that is not there is made of default.
    """

    changed: np.ndarray
    default: float = 0.0

    def applied(self, costs: np.ndarray, present: Optional[np.ndarray]) -> np.ndarray:
        """(V,) float32: the costs of the Edit over those of the layer that is there, if one is."""
        return np.where(self.changed, costs, self.default if present is None else present).astype(
            np.float32
        )


@dataclass
class Edit:
    """Arrays as in Mesh. In the dictionaries, None removes what has that key.

    costs_updates: of layers in vertex_costs of which only some values are meant.

    layer_parameters, vertex_parameters, face_parameters: of the layers and attributes in this edit;
    a layer that is not in vertex_costs keeps its parameters.
    remove: names of members below that hold one array, which is to go: "vertex_normals",
    "vertex_colors", "texture_coordinates", "materials", "features".
    """

    vertex_costs: Dict[str, Optional[np.ndarray]] = field(default_factory=dict)
    costs_updates: Dict[str, CostsUpdate] = field(default_factory=dict)
    layer_parameters: Dict[str, Optional[Dict[str, Any]]] = field(default_factory=dict)
    face_attributes: Dict[str, Optional[np.ndarray]] = field(default_factory=dict)
    face_parameters: Dict[str, Optional[Dict[str, Any]]] = field(default_factory=dict)
    vertex_attributes: Dict[str, Optional[np.ndarray]] = field(default_factory=dict)
    vertex_parameters: Dict[str, Optional[Dict[str, Any]]] = field(default_factory=dict)
    labels: Dict[str, Optional[Label]] = field(default_factory=dict)
    textures: Dict[int, Optional[np.ndarray]] = field(default_factory=dict)
    vertex_normals: Optional[np.ndarray] = None
    vertex_colors: Optional[np.ndarray] = None
    texture_coordinates: Optional[np.ndarray] = None
    materials: Optional[Materials] = None
    features: Optional[Features] = None
    frame_id: Optional[str] = None
    origin: Optional[Tuple[float, float, float]] = None
    crs: Optional[str] = None
    source: Optional[Dict[str, Any]] = None
    remove: FrozenSet[str] = frozenset()


def changed_labels(
    labels: Mapping[str, Label], changes: Mapping[str, Optional[Label]]
) -> Dict[str, Label]:
    """Labels with changes of them, as those of an Edit; tree_2 before tree_10."""
    found = {**labels, **changes}
    texts = sorted((text for text in found if found[text] is not None), key=natural_order)
    return {text: found[text] for text in texts}


def is_empty(edit: Edit) -> bool:
    """True if it changes nothing."""
    return all(
        getattr(edit, member.name) is None
        if member.default is None
        else not getattr(edit, member.name)
        for member in fields(edit)
    )
