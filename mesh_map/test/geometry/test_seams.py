"""Meshes with copies along seams, put together again by where they are."""

import numpy as np
import pytest
from mesh_map.geometry.seams import stitched_faces
from mesh_map.geometry.topology import Topology
from meshes import small_meshes, terrain
from seam_maps import MODELS


def pieces(vertices, faces, number):
    """(vertices, faces, original of each vertex): faces of another number share no vertices."""
    keys = np.asarray(faces, np.int64) + len(vertices) * np.asarray(number)[:, None]
    found, corners = np.unique(keys, return_inverse=True)
    originals = found % len(vertices)
    return np.asarray(vertices)[originals], corners.reshape(-1, 3), originals


@pytest.mark.parametrize("name", MODELS)
def test_what_seams_have_cut_is_whole(name):
    vertices, faces, uv = MODELS[name]()
    number = np.unique(uv.mean(axis=1).round(), axis=0, return_inverse=True)[1].reshape(-1)
    cut, corners, originals = pieces(vertices, faces, number)
    assert len(cut) > len(vertices)
    found = stitched_faces(cut, corners)
    topology = Topology(faces=faces, vertex_count=len(vertices))
    of_found = Topology(faces=found, vertex_count=len(cut))
    assert np.array_equal(originals[found], faces)
    assert of_found.edge_count == topology.edge_count
    assert of_found.border_edges.sum() == topology.border_edges.sum()


@pytest.mark.parametrize("mesh", small_meshes(), ids=lambda mesh: mesh.name)
def test_other_meshes_stay_as_they_are(mesh):
    """Whatever the mesh: corners stay at their places, and a mesh without borders is the same."""
    found = stitched_faces(mesh.vertices, mesh.faces)
    vertices = np.float32(mesh.vertices) + np.float32(0)
    assert np.array_equal(vertices[found], vertices[mesh.faces])
    topology = Topology(faces=mesh.faces, vertex_count=len(mesh.vertices))
    if not topology.border_edges.any() or len(np.unique(vertices, axis=0)) == len(vertices):
        assert np.array_equal(found, mesh.faces)


def test_three_borders_at_one_place_are_not_joined():
    mesh = terrain(4)
    number = np.arange(len(mesh.faces)) % 2
    cut, corners, _ = pieces(mesh.vertices, mesh.faces, number)
    twice = np.concatenate([corners, corners + len(cut)])
    found = stitched_faces(np.concatenate([cut, cut]), twice)
    inner = Topology(faces=found, vertex_count=2 * len(cut))
    assert inner.edge_face_counts.max() == 2
