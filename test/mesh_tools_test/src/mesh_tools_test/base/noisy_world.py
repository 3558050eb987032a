"""The map that is measured: the outdoor world with the noise of a scanner."""

from typing import Any, Dict, List, NamedTuple

import numpy as np
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.map.mesh_map import MeshMap
from mesh_msgs.outdoor_world import outdoor_world

NOISE = 0.003  # meters, of each coordinate
STEP = 0.4  # meters of height difference that are lethal in the benchmark


class World(NamedTuple):
    """vertices (V, 3) float32, faces (F, 3) uint32, colors (V, 3) uint8."""

    vertices: np.ndarray
    faces: np.ndarray
    colors: np.ndarray

    def fresh_geometry(self) -> MeshGeometry:
        """With topology and normals, and nothing that layers compute."""
        geometry = MeshGeometry(self.vertices, self.faces)
        assert geometry.topology.edge_count and len(geometry.vertex_normals)
        return geometry


def noisy_world(faces: int, seed: int = 0) -> World:
    """About that many faces."""
    world = outdoor_world(faces=faces, seed=seed)
    noise = np.random.default_rng(seed).normal(0.0, NOISE, world.vertices.shape)
    vertices = np.ascontiguousarray(world.vertices + noise, np.float32)
    return World(vertices, np.ascontiguousarray(world.faces, np.uint32), world.colors)


def layer(name: str, kind: str, **params: Any) -> Dict[str, Any]:
    """An entry of a list of layers."""
    return {"name": name, "type": "mesh_layers/%sLayer" % kind, "params": params}


def map_with(geometry: MeshGeometry, layers: List[Dict[str, Any]]) -> MeshMap:
    """A map with these layers; RuntimeError if one is left out."""
    mesh_map = MeshMap.of(geometry)
    mesh_map.compute_layers(layers)
    if mesh_map.layer_errors:
        raise RuntimeError("layers are left out: %s" % mesh_map.layer_errors)
    return mesh_map
