"""Meshes for the tests: the zoo, random soups of triangles, and real ones where present."""

import os
from functools import lru_cache
from pathlib import Path
from typing import List, NamedTuple

import numpy as np
import pytest
from mesh_msgs import zoo
from mesh_msgs_hdf5.formats.importer import read_mesh

DATA = Path(
    os.environ.get("MESH_TOOLS_DATA", Path(__file__).resolve().parents[4] / "shared" / "data")
)


class TestMesh(NamedTuple):
    """A mesh that equals itself alone, so that what was computed of it can be kept."""

    __test__ = False
    name: str
    vertices: np.ndarray
    faces: np.ndarray

    def __eq__(self, other):
        return self is other

    def __hash__(self):
        return id(self)


def soup(seed: int, vertex_count: int = 9, face_count: int = 25) -> TestMesh:
    """Random faces on few vertices: degenerate and duplicate faces, and edges of many faces."""
    random = np.random.default_rng(seed)
    vertices = random.normal(size=(vertex_count, 3)).astype(np.float32)
    faces = random.integers(0, vertex_count, (face_count, 3)).astype(np.uint32)
    return TestMesh("soup_%d" % seed, vertices, faces)


def small_meshes() -> List[TestMesh]:
    """The zoo without empty meshes, and some soups."""
    meshes = [TestMesh(m.name, m.vertices, m.faces) for m in zoo.all_meshes() if len(m.faces)]
    return meshes + [soup(seed) for seed in range(5)] + [soup(5, 200, 150), soup(6, 60, 300)]


def terrain(size: int = 40, seed: int = 1) -> TestMesh:
    """A rough grid of size x size vertices, about 0.1 m apart."""
    random = np.random.default_rng(seed)
    x, y = np.meshgrid(np.arange(size) * 0.1, np.arange(size) * 0.1, indexing="ij")
    vertices = np.stack([x, y, 0.3 * np.sin(x) * np.cos(2 * y)], -1).reshape(-1, 3)
    vertices += random.normal(0, 0.02, vertices.shape)
    corner = np.arange(size * size).reshape(size, size)[:-1, :-1].ravel()
    lower = np.stack([corner, corner + size, corner + size + 1], 1)
    upper = np.stack([corner, corner + size + 1, corner + 1], 1)
    faces = np.stack([lower, upper], 1).reshape(-1, 3)
    return TestMesh("terrain", vertices.astype(np.float32), faces.astype(np.uint32))


def data_mesh(name: str) -> TestMesh:
    """A mesh of the data folder; skips the test where that is absent."""
    path = DATA / name
    if not path.exists():
        pytest.skip("%s is absent; set MESH_TOOLS_DATA to the folder that holds it" % path)
    return _read(path)


@lru_cache(maxsize=None)
def _read(path: Path) -> TestMesh:
    mesh, _ = read_mesh(str(path))
    for array in (mesh.vertices, mesh.faces):
        array.flags.writeable = False
    return TestMesh(path.stem, mesh.vertices, mesh.faces)


def renumbered(mesh: TestMesh, seed: int = 3):
    """The mesh with its vertices in another order, and new[old] of the vertex indices."""
    order = np.random.default_rng(seed).permutation(len(mesh.vertices))
    new = np.zeros(len(order), np.uint32)
    new[order] = np.arange(len(order), dtype=np.uint32)
    return TestMesh(mesh.name + "_renumbered", mesh.vertices[order], new[mesh.faces]), new


TRAY, BOTANICAL = "tray.ply", "botanical_garden_gazebo.ply"
SMALL = small_meshes()
small = pytest.mark.parametrize("mesh", SMALL, ids=[mesh.name for mesh in SMALL])
real = pytest.mark.parametrize("name", [TRAY, BOTANICAL])
