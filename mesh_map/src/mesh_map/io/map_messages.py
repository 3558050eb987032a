"""Messages about a map. Frame and UUID are those of the map.

The stamp is 0: a map does not age, and transforms are looked up as they are when it is shown.
"""

import math
from typing import Any, Mapping

import numpy as np
from mesh_map.costs.combination import COMBINED_COSTS
from mesh_map.io.layer_meanings import layer_meaning
from mesh_map.map.mesh_map import MeshMap
from mesh_msgs import arrays
from mesh_msgs.msg import LayerInfo, LayerInfoArray
from mesh_msgs_hdf5.ros.map_messages import layer_info
from std_msgs.msg import Header


def geometry_message(mesh_map: MeshMap) -> arrays.MeshGeometryStamped:
    """Vertices, one normal for each, and faces; with the copies along seams that textures need."""
    split = mesh_map.geometry.split
    vertices, normals, faces = mesh_map.vertices, mesh_map.vertex_normals, mesh_map.faces
    if split is not None:
        vertices, normals, faces = split.vertices, split.vertex_values(normals), split.faces
    geometry = arrays.MeshGeometry(vertices, normals, faces)
    return _about(mesh_map, arrays.MeshGeometryStamped, mesh_geometry=geometry)


def colors_message(mesh_map: MeshMap, colors: np.ndarray) -> arrays.MeshVertexColorsStamped:
    """colors: (V, 3 or more) uint8 of the mesh as it is shown, of which red, green and blue are
    used; alpha is 1."""
    rgba = np.ones((len(colors), 4), np.float32)
    np.divide(colors[:, :3], np.float32(255), out=rgba[:, :3])
    found = arrays.MeshVertexColors(rgba)
    return _about(mesh_map, arrays.MeshVertexColorsStamped, mesh_vertex_colors=found)


def costs_message(mesh_map: MeshMap, name: str, costs: np.ndarray) -> arrays.MeshVertexCostsStamped:
    """costs: (V,) float32, of the layer of this name; copies along seams have those of their
    originals."""
    split = mesh_map.geometry.split
    costs = costs if split is None else split.vertex_values(costs)
    found = arrays.MeshVertexCosts(costs)
    return _about(mesh_map, arrays.MeshVertexCostsStamped, type=name, mesh_vertex_costs=found)


def update_message(
    mesh_map: MeshMap, name: str, vertices: np.ndarray, costs: np.ndarray
) -> arrays.MeshVertexCostsSparseStamped:
    """vertices: (K,) that have changed; costs: (K,) float32, what they cost now. So do their copies
    along seams."""
    split = mesh_map.geometry.split
    if split is not None:
        vertices, rows = split.with_copies(vertices)
        costs = costs[rows]
    found = arrays.MeshVertexCostsSparse(vertices, costs, math.nan)
    return _about(mesh_map, arrays.MeshVertexCostsSparseStamped, type=name, mesh_vertex_costs=found)


def face_costs_message(
    mesh_map: MeshMap, name: str, costs: np.ndarray
) -> arrays.MeshFaceCostsStamped:
    """costs: (F,) float32."""
    found = arrays.MeshFaceCosts(costs)
    return _about(mesh_map, arrays.MeshFaceCostsStamped, type=name, mesh_face_costs=found)


def layer_info_message(
    mesh_map: MeshMap, cost_limit: float, others: Mapping[str, str]
) -> LayerInfoArray:
    """What the costs of the layers mean now, then of Combined Costs.

    Args:
        mesh_map: with its layers.
        cost_limit: of planners, see LayerInfo; NaN for none.
        others: name -> what +inf means, of costs beside those of the map.
    """
    message = _about(mesh_map, LayerInfoArray)
    message.layers = [
        layer_info(layer.name, layer_meaning(layer))
        for layer in mesh_map.layers.values()
        if layer.result is not None
    ]
    costs = mesh_map.planning_costs().costs
    message.layers.append(
        LayerInfo(
            name=COMBINED_COSTS,
            infinity="lethal",
            threshold=math.nan,
            cost_limit=cost_limit,
            lethal=np.count_nonzero(np.isposinf(costs)),
            unknown=np.count_nonzero(np.isnan(costs)),
        )
    )
    message.layers += [
        LayerInfo(name=name, infinity=infinity, threshold=math.nan, cost_limit=math.nan)
        for name, infinity in others.items()
    ]
    return message


def _about(mesh_map: MeshMap, kind: Any, **members: Any) -> Any:
    header = Header(frame_id=mesh_map.frame_id)
    return kind(header=header, uuid=mesh_map.uuid, **members)
