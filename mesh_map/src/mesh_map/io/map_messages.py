"""Messages about a map. Frame and UUID are those of the map.

The stamp is 0: a map does not age, and transforms are looked up as they are when it is shown.
"""

import math

import numpy as np
from mesh_map.map.mesh_map import MeshMap
from mesh_msgs import arrays
from std_msgs.msg import Header


def geometry_message(mesh_map: MeshMap) -> arrays.MeshGeometryStamped:
    """Vertices, one normal for each, and faces."""
    return arrays.MeshGeometryStamped(
        header=_header(mesh_map),
        uuid=mesh_map.uuid,
        mesh_geometry=arrays.MeshGeometry(
            vertices=mesh_map.vertices,
            vertex_normals=mesh_map.vertex_normals,
            faces=mesh_map.faces,
        ),
    )


def colors_message(mesh_map: MeshMap, colors: np.ndarray) -> arrays.MeshVertexColorsStamped:
    """colors: (V, 3 or more) uint8, of which red, green and blue are used; alpha is 1."""
    rgba = np.ones((len(colors), 4), np.float32)
    np.divide(colors[:, :3], np.float32(255), out=rgba[:, :3])
    return arrays.MeshVertexColorsStamped(
        header=_header(mesh_map),
        uuid=mesh_map.uuid,
        mesh_vertex_colors=arrays.MeshVertexColors(vertex_colors=rgba),
    )


def costs_message(mesh_map: MeshMap, name: str, costs: np.ndarray) -> arrays.MeshVertexCostsStamped:
    """costs: (V,) float32, of the layer of this name."""
    return arrays.MeshVertexCostsStamped(
        header=_header(mesh_map),
        uuid=mesh_map.uuid,
        type=name,
        mesh_vertex_costs=arrays.MeshVertexCosts(costs=costs),
    )


def update_message(
    mesh_map: MeshMap, name: str, vertices: np.ndarray, costs: np.ndarray
) -> arrays.MeshVertexCostsSparseStamped:
    """vertices: (K,) that have changed; costs: (K,) float32, what they cost now."""
    return arrays.MeshVertexCostsSparseStamped(
        header=_header(mesh_map),
        uuid=mesh_map.uuid,
        type=name,
        mesh_vertex_costs=arrays.MeshVertexCostsSparse(
            vertices=vertices, costs=costs, default_value=math.nan
        ),
    )


def face_costs_message(
    mesh_map: MeshMap, name: str, costs: np.ndarray
) -> arrays.MeshFaceCostsStamped:
    """costs: (F,) float32."""
    return arrays.MeshFaceCostsStamped(
        header=_header(mesh_map),
        uuid=mesh_map.uuid,
        type=name,
        mesh_face_costs=arrays.MeshFaceCosts(costs=costs),
    )


def _header(mesh_map: MeshMap) -> Header:
    return Header(frame_id=mesh_map.frame_id)
