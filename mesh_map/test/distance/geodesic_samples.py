"""Exact geodesic distances, sampled, on meshes that tests can make again.

`make_exact_geodesics.py` computed them with the algorithm of Mitchell, Mount and Papadimitriou; the
file beside this one holds the numbers, this module the meshes and the reading.
"""

from pathlib import Path
from typing import Callable, Dict, NamedTuple

import numpy as np
from mesh_map.geometry.topology import Topology
from mesh_msgs import zoo
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

import meshes

_CORNERS = ((0, 0), (1, 0), (1, 1), (0, 1))  # of a square, around it
FILE = Path(__file__).with_name("exact_geodesics.npz")


class Samples(NamedTuple):
    """sources (S,) vertices, vertices (N,), distances (S, N) float32 meters from each source."""

    mesh: meshes.TestMesh
    sources: np.ndarray
    vertices: np.ndarray
    distances: np.ndarray

    def beyond(self, edges: float) -> np.ndarray:
        """(S, N) bool: which are at least that many mean edge lengths from their source."""
        return self.distances >= edges * mean_edge(self.mesh)


def mean_edge(mesh: meshes.TestMesh) -> float:
    """Mean length of the sides of faces (m)."""
    return float(_sides(mesh).mean())


def manifold_part(mesh: meshes.TestMesh) -> meshes.TestMesh:
    """The largest piece of what remains without faces that the exact algorithm cannot take.

    These are faces without area, at edges of more than two faces, and at vertices where pieces of
    surface meet that share no edge there.
    """
    faces = mesh.faces.astype(np.int64)
    points = mesh.vertices.astype(np.float64)
    a, b, c = (points[faces[:, k]] for k in range(3))
    faces = faces[np.linalg.norm(np.cross(b - a, c - a), axis=1) > 1e-12]
    keys = _edge_keys(faces, len(points))
    _, inverse, counts = np.unique(keys, return_inverse=True, return_counts=True)
    faces = faces[(counts[inverse.reshape(3, -1)] <= 2).all(axis=0)]

    bow_ties = Topology(faces=faces, vertex_count=len(points)).non_manifold_vertices
    while bow_ties.any():
        faces = faces[~bow_ties[faces].any(axis=1)]
        bow_ties = Topology(faces=faces, vertex_count=len(points)).non_manifold_vertices

    # pieces: faces are neighbors where they share an edge
    keys = _edge_keys(faces, len(points))
    order = np.argsort(keys, kind="stable")
    same = np.flatnonzero(keys[order][1:] == keys[order][:-1])
    first, second = order[same] % len(faces), order[same + 1] % len(faces)
    shape = (len(faces), len(faces))
    pieces = connected_components(coo_matrix((np.ones(len(same)), (first, second)), shape))[1]
    faces = faces[pieces == np.argmax(np.bincount(pieces))]
    used = np.unique(faces)
    return meshes.TestMesh(
        mesh.name, mesh.vertices[used], np.searchsorted(used, faces).astype(np.uint32)
    )


def fingerprint(mesh: meshes.TestMesh) -> np.ndarray:
    """(3,) float64 that tell a mesh from another, but not bits that differ between platforms."""
    weight = 1.0 + np.arange(len(mesh.faces)) % 7
    return np.array([len(mesh.vertices), len(mesh.faces), float((weight * _sides(mesh)).sum())])


def samples(name: str) -> Samples:
    """Those of a mesh of `RECIPES`; skips the test where its file is absent."""
    mesh = RECIPES[name]()
    with np.load(FILE) as file:
        kept = {key: file["%s/%s" % (name, key)] for key in ("mesh",) + Samples._fields[1:]}
    if not np.allclose(fingerprint(mesh), kept.pop("mesh"), rtol=1e-5):
        raise AssertionError(
            "the mesh %s is not the one whose exact distances are kept: run %s"
            % (name, FILE.with_name("make_exact_geodesics.py").name)
        )
    return Samples(mesh=mesh, **kept)


def rough_world(noise: float, faces: int = 20_000, seed: int = 0) -> meshes.TestMesh:
    """The ground of the generated outdoor world with that much vertical noise (m)."""
    world = zoo.outdoor_world(faces=faces, seed=seed)
    vertices = world.vertices.copy()
    vertices[:, 2] += np.random.default_rng(seed).normal(0.0, noise, len(vertices))
    return manifold_part(meshes.TestMesh("rough_world", vertices, world.faces))


def rough_terrain(size: int = 160, holes: int = 0, seed: int = 0) -> meshes.TestMesh:
    """A scan of natural ground: 22 m wide, irregular triangles of 0.16 m, 15 degrees steep on
    average, with ridges of all sizes, 3 mm of noise, pinholes, and round holes of up to 2 m."""
    random = np.random.default_rng(seed)
    spacing = 0.137
    index = np.arange(size * size).reshape(size, size)
    points = np.stack(np.divmod(index.ravel(), size), 1).astype(np.float64)
    points += random.uniform(-0.24, 0.24, points.shape)
    points *= spacing
    heights = random.normal(0.0, 0.003, len(points))
    for octave in range(28):
        wave = 16.0 / 2 ** (octave // 4)
        angle, phase = random.uniform(0.0, 2.0 * np.pi, 2)
        along = points @ [np.cos(angle), np.sin(angle)]
        heights += 0.015 * wave**0.7 * np.sin(2.0 * np.pi * along / wave + phase)
    a, b, c, d = (index[i : size - 1 + i, j : size - 1 + j].ravel() for i, j in _CORNERS)
    turned = random.random((size - 1) ** 2) < 0.5
    last, first = np.where(turned, d, c), np.where(turned, b, a)
    faces = np.concatenate([np.stack([a, b, last], 1), np.stack([c, d, first], 1)])
    centers = random.uniform(0.0, size * spacing, (holes, 2))
    middles = points[faces].mean(axis=1)
    kept = random.random(len(faces)) > 0.003
    for center, radius in zip(centers, random.uniform(0.1, 1.0, holes)):
        kept &= np.hypot(*(middles - center).T) > radius
    vertices = np.column_stack([points, heights]).astype(np.float32)
    return manifold_part(meshes.TestMesh("rough_terrain", vertices, faces[kept].astype(np.uint32)))


def _of_zoo(mesh: zoo.ZooMesh) -> meshes.TestMesh:
    return meshes.TestMesh(mesh.name, mesh.vertices, mesh.faces)


def _botanical_part() -> meshes.TestMesh:
    """What lies within 6 m of the middle of the garden."""
    mesh = meshes.data_mesh(meshes.BOTANICAL)
    middle = np.median(mesh.vertices[:, :2], axis=0)
    near = np.abs(mesh.vertices[:, :2] - middle).max(axis=1) < 6.0
    faces = mesh.faces[near[mesh.faces].all(axis=1)]
    return manifold_part(meshes.TestMesh("botanical", mesh.vertices, faces))


def _edge_keys(faces: np.ndarray, count: int) -> np.ndarray:
    """(3 F,) numbers that are alike for alike edges; all first sides come first."""
    return np.concatenate(
        [
            np.minimum(faces[:, k], faces[:, k - 1]) * count
            + np.maximum(faces[:, k], faces[:, k - 1])
            for k in range(3)
        ]
    )


def _sides(mesh: meshes.TestMesh) -> np.ndarray:
    """(F,) mean length of the three sides of each face (m)."""
    points = mesh.vertices.astype(np.float64)[mesh.faces]
    return np.linalg.norm(points - np.roll(points, 1, axis=1), axis=2).mean(axis=1)


RECIPES: Dict[str, Callable[[], meshes.TestMesh]] = {
    "sphere": lambda: _of_zoo(zoo.sphere(subdivisions=4)),
    "torus": lambda: _of_zoo(zoo.torus(around=96, across=48)),
    "two_storeys": lambda: _of_zoo(zoo.two_storeys(cells=48)),
    "hole": lambda: _of_zoo(zoo.hole(cells=45)),
    "moebius_strip": lambda: _of_zoo(zoo.moebius_strip(around=160, across=20)),
    "hills": lambda: meshes.terrain(size=70),
    "rough_terrain": rough_terrain,
    "terrain_with_holes": lambda: rough_terrain(holes=12),
    "world": lambda: rough_world(0.003),
    "world_20mm": lambda: rough_world(0.02),
    "tray": lambda: manifold_part(meshes.data_mesh(meshes.TRAY)),
    "botanical": _botanical_part,
}
