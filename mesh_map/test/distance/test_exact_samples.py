"""The wave front, paths and shortened paths beside exact geodesic distances."""

from functools import lru_cache

import geodesic_samples
import numpy as np
import pytest
from cost_oracles import edge_graph_potential
from geodesic_samples import RECIPES
from mesh_map.distance.exact_geodesic import ExactGeodesic
from mesh_map.distance.surface_path import FieldTracer
from mesh_map.distance.wave_front import WaveFrontSolver
from mesh_map.geometry.mesh_geometry import MeshGeometry

# Percent of the distance, beyond ten edges: mean and 99th percentile of the error, and how far
# below the exact distance the lowest potential may be. Coarse meshes bend much from face to face.
BOUNDS = {
    "rough_terrain": (0.12, 0.4, 1.0),
    "terrain_with_holes": (0.16, 0.65, 1.1),
    "sphere": (0.3, 0.9, 1.5),
    "torus": (0.15, 0.7, 1.2),
    "two_storeys": (0.12, 0.5, 0.1),
    "hole": (0.15, 0.7, 0.5),
    "moebius_strip": (0.06, 0.2, 0.1),
    "hills": (0.35, 1.0, 2.1),
    "world": (0.25, 0.9, 1.1),
    "world_20mm": (0.32, 1.25, 1.6),
    "tray": (0.01, 0.1, 1.8),
    "botanical": (0.45, 1.5, 1.5),
}
EVERY = pytest.mark.parametrize("name", list(RECIPES))


@lru_cache(maxsize=None)
def prepared(name):
    """The samples, and the geometry of their mesh."""
    samples = geodesic_samples.samples(name)
    return samples, MeshGeometry(samples.mesh.vertices, samples.mesh.faces)


def errors(name):
    """Percent of the distance, those beyond ten edges."""
    samples, geometry = prepared(name)
    solver = WaveFrontSolver.of(geometry)
    rows = [solver.solve(int(source)).labels[samples.vertices] for source in samples.sources]
    far = samples.beyond(10.0)
    return 100.0 * (np.array(rows)[far] / samples.distances[far] - 1.0)


@EVERY
def test_the_wave_front_is_near_the_exact_distance(name):
    found = errors(name)
    mean, most, below = BOUNDS[name]
    assert len(found) > 1000
    assert np.abs(found).mean() <= mean
    assert np.percentile(np.abs(found), 99) <= most
    assert found.min() >= -below


@EVERY
def test_the_wave_front_is_never_longer_than_edges(name):
    samples, geometry = prepared(name)
    source = int(samples.sources[0])
    labels = WaveFrontSolver.of(geometry).solve(source).labels
    edges = edge_graph_potential(samples.mesh, source)
    assert (labels <= edges * (1 + 1e-6)).all()
    far = edges > 10.0 * geodesic_samples.mean_edge(samples.mesh)
    assert np.median(labels[far] / edges[far]) < 0.97


class Corner:
    """A vertex as a place on the surface."""

    def __init__(self, geometry, vertex):
        self.face = int(geometry.topology.faces_of(vertex)[0])
        self.position = geometry.vertices[vertex].astype(np.float64)


def traced(name, count):
    """(exact distance, path, goal place, geometry) of sampled pairs, and the potentials there."""
    samples, geometry = prepared(name)
    solver, tracer = WaveFrontSolver.of(geometry), FieldTracer.of(geometry)
    random = np.random.default_rng(0)
    for row, source in enumerate(samples.sources):
        field = solver.solve(Corner(geometry, source))
        for column in random.choice(len(samples.vertices), count, replace=False):
            vertex = int(samples.vertices[column])
            if vertex != source:
                path = tracer.path(field, Corner(geometry, vertex))
                yield float(samples.distances[row, column]), path, field.labels[vertex]


@EVERY
def test_no_path_is_shorter_than_exact_ones(name):
    lengths, exact, labels = [], [], []
    for distance, path, label in traced(name, 40):
        lengths.append(path.length)
        exact.append(distance)
        labels.append(label)
    lengths, exact, labels = (np.array(values) for values in (lengths, exact, labels))
    # float32 samples allow no more than a few millionths
    assert (lengths >= exact * (1 - 1e-5)).all()
    assert np.mean(np.abs(lengths / labels - 1.0) > 0.01) <= MOST_OFF.get(name, 0.01)


# Share of paths whose length is over one percent off the potential at their start, where it is more
# than one in a hundred: on rough ground with long edges.
MOST_OFF = {"hills": 0.13, "world_20mm": 0.02, "botanical": 0.15}

# Median share by which shortened paths are longer than exact ones. Where the ground bends at every
# vertex, the locally shortest path is often another one than the shortest of all.
EXCESS = {"rough_terrain": 5e-4, "terrain_with_holes": 5e-4, "hills": 8e-4, "botanical": 2e-4}


@EVERY
def test_shortened_paths_are_near_the_exact_distance(name):
    _, geometry = prepared(name)
    shorter = ExactGeodesic.of(geometry)
    excess, over_hills = [], []
    for distance, path, _ in traced(name, 25):
        short = shorter.shorten(path)
        assert short.length <= path.length * (1 + 1e-9)
        excess.append(short.length / distance - 1.0)
        over_hills.append(shorter.shorten(path, over_hills=True).length / distance - 1.0)
    assert min(excess) >= -1e-5 and min(over_hills) >= -1e-5
    assert np.median(excess) < EXCESS.get(name, 1e-6)
    assert np.median(over_hills) < 2e-4
