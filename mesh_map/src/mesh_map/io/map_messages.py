"""Messages about a map. Frame and UUID are those of the map.

The stamp is 0: a map does not age, and transforms are looked up as they are when it is shown.
"""

import math
from typing import Any

import numpy as np
from mesh_map.map.mesh_map import MeshMap
from mesh_msgs import arrays
from std_msgs.msg import Header


def geometry_message(mesh_map: MeshMap) -> arrays.MeshGeometryStamped:
    """Vertices, one normal for each, and faces."""
    geometry = arrays.MeshGeometry(mesh_map.vertices, mesh_map.vertex_normals, mesh_map.faces)
    return _about(mesh_map, arrays.MeshGeometryStamped, mesh_geometry=geometry)


def colors_message(mesh_map: MeshMap, colors: np.ndarray) -> arrays.MeshVertexColorsStamped:
    """colors: (V, 3 or more) uint8, of which red, green and blue are used; alpha is 1."""
    rgba = np.ones((len(colors), 4), np.float32)
    np.divide(colors[:, :3], np.float32(255), out=rgba[:, :3])
    found = arrays.MeshVertexColors(rgba)
    return _about(mesh_map, arrays.MeshVertexColorsStamped, mesh_vertex_colors=found)


def costs_message(mesh_map: MeshMap, name: str, costs: np.ndarray) -> arrays.MeshVertexCostsStamped:
    """costs: (V,) float32, of the layer of this name."""
    found = arrays.MeshVertexCosts(costs)
    return _about(mesh_map, arrays.MeshVertexCostsStamped, type=name, mesh_vertex_costs=found)


def update_message(
    mesh_map: MeshMap, name: str, vertices: np.ndarray, costs: np.ndarray
) -> arrays.MeshVertexCostsSparseStamped:
    """vertices: (K,) that have changed; costs: (K,) float32, what they cost now."""
    found = arrays.MeshVertexCostsSparse(vertices, costs, math.nan)
    return _about(mesh_map, arrays.MeshVertexCostsSparseStamped, type=name, mesh_vertex_costs=found)


def face_costs_message(
    mesh_map: MeshMap, name: str, costs: np.ndarray
) -> arrays.MeshFaceCostsStamped:
    """costs: (F,) float32."""
    found = arrays.MeshFaceCosts(costs)
    return _about(mesh_map, arrays.MeshFaceCostsStamped, type=name, mesh_face_costs=found)


def _about(mesh_map: MeshMap, kind: Any, **members: Any) -> Any:
    header = Header(frame_id=mesh_map.frame_id)
    return kind(header=header, uuid=mesh_map.uuid, **members)
