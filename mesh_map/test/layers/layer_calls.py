"""Layers by the names of their types, evaluated on a mesh alone or with given lethal vertices."""

from functools import lru_cache

import numpy as np
from layer_oracles import OracleMesh
from mesh_map.base.plugins import find_class
from mesh_map.costs.layer import BASE_CLASS_TYPE, LayerInput
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.map.mesh_map import MeshMap
from meshes import SMALL, TestMesh, data_mesh, terrain


def made(kind, **params):
    """A layer mesh_layers/<kind>Layer."""
    type_name = "mesh_layers/%sLayer" % kind
    return find_class("mesh_map", BASE_CLASS_TYPE, type_name)(kind.lower(), params, type_name)


def evaluated(kind, mesh, lethal=None, geometry=None, **params):
    """LayerResult of mesh_layers/<kind>Layer; lethal: indices of lethal vertices of its input.

    geometry: keyword arguments of MeshGeometry.
    """
    mesh_map = MeshMap.of(MeshGeometry(mesh.vertices, mesh.faces, **(geometry or {})))
    inputs = {}
    if lethal is not None:
        mask = np.zeros(len(mesh.vertices), bool)
        mask[lethal] = True
        costs = np.where(mask, np.float32(np.inf), np.float32(0))
        inputs["given"] = LayerInput(costs, mask, None, 1.0)
    return made(kind, **params).evaluate(mesh_map, inputs)


@lru_cache(maxsize=None)
def scaled(mesh_name):
    """A mesh by its name, and its oracle; those of the zoo with edges of 0.2 m."""
    mesh = {mesh.name: mesh for mesh in SMALL}.get(mesh_name)
    if mesh_name == "terrain":
        mesh = terrain()
    elif mesh is None:
        mesh = data_mesh(mesh_name)
    else:
        edges = OracleMesh(mesh).lengths
        factor = 0.2 / edges.mean() if len(edges) else 1.0
        mesh = TestMesh(mesh.name, (mesh.vertices * factor).astype(np.float32), mesh.faces)
    return mesh, OracleMesh(mesh)
