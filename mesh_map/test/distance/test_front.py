"""Distances from obstacles in Python: refused, cancelled, and one mesh for a geometry."""

import gc

import numpy as np
import pytest
from mesh_map import MeshMap
from mesh_map.base.cancel import CancelFlag
from mesh_map.base.errors import Canceled
from mesh_map.distance.obstacle_distance import ObstacleDistance, SurfaceFront
from meshes import terrain


@pytest.fixture(scope="module")
def front():
    mesh = terrain()
    return SurfaceFront.of(MeshMap(mesh.vertices, mesh.faces).geometry)


def test_one_front_for_a_geometry():
    mesh = terrain(10)
    geometry = MeshMap(mesh.vertices, mesh.faces).geometry
    front = SurfaceFront.of(geometry)
    assert SurfaceFront.of(geometry) is front
    other = SurfaceFront.of(MeshMap(mesh.vertices, mesh.faces).geometry)
    assert other is not front
    del geometry
    gc.collect()
    obstacles = ObstacleDistance(front=front, max_distance=20.0)
    obstacles.compute(np.arange(100) == 0)
    assert obstacles.distances()[0] == 0


def test_obstacles_are_refused(front):
    with pytest.raises(ValueError, match="the maximum distance has to be above 0"):
        ObstacleDistance(front=front, max_distance=0.0)
    with pytest.raises(ValueError, match="lethal has to have the shape"):
        ObstacleDistance(front=front, max_distance=1.0).compute(np.zeros(3, bool))


def test_a_cancelled_run_is_an_error():
    mesh = terrain(150)
    front = SurfaceFront.of(MeshMap(mesh.vertices, mesh.faces).geometry)
    flag = CancelFlag()
    flag.set()
    lethal = np.arange(150 * 150) % 97 == 0
    obstacles = ObstacleDistance(front=front, max_distance=5.0)
    with pytest.raises(Canceled):
        obstacles.compute(lethal, flag)
    obstacles.compute(lethal)
    assert np.isfinite(obstacles.distances()).all()
