"""A triangle mesh with its attributes, as arrays."""
from dataclasses import dataclass, field
from typing import Any, Dict, Optional

import numpy as np
from mesh_msgs.identity import geometry_uuid


@dataclass
class Mesh:
    """One mesh as it stands in a map file.

    vertices: (V, 3) float32, meters in frame_id, REP 103 axes.
    faces: (F, 3) uint32, vertex indices, counter-clockwise seen from outside.
    vertex_normals: (V, 3) float32 or None.
    vertex_colors: (V, 3) uint8 red, green, blue, or None.
    vertex_costs: layer name -> (V,) float32; finite >= 0 is a cost, +inf is lethal, NaN is unknown.
    layer_parameters: layer name -> the parameters it was computed with (what json can write).
    frame_id: the coordinate frame.
    source: where the mesh comes from (what json can write).
    """

    vertices: np.ndarray
    faces: np.ndarray
    vertex_normals: Optional[np.ndarray] = None
    vertex_colors: Optional[np.ndarray] = None
    vertex_costs: Dict[str, np.ndarray] = field(default_factory=dict)
    frame_id: str = "map"
    source: Dict[str, Any] = field(default_factory=dict)
    layer_parameters: Dict[str, Dict[str, Any]] = field(default_factory=dict)

    @property
    def uuid(self) -> str:
        """The version 5 UUID of vertices and faces (computed at each call)."""
        return geometry_uuid(self.vertices, self.faces)
