"""Accuracy, completeness and soundness, of meshes for which they are known."""

import numpy as np
import pytest
from mesh_map.base.errors import MeshMapError
from mesh_map.geometry.crop import Region
from mesh_map.geometry.mesh_comparison import compare_meshes, soundness, surface_samples
from mesh_msgs import zoo
from meshes import small, terrain

HALF = Region(np.array([-9.0, -9.0, -9.0]), np.array([5.0, 99.0, 9.0]))


def compared(truth, mesh, **options):
    return compare_meshes(
        truth.vertices, truth.faces, mesh.vertices, mesh.faces, **{"samples": 4000, **options}
    )


@small
def test_a_mesh_is_the_truth_of_itself(mesh):
    if mesh.name == "far_sphere" or not face_area(mesh):
        return
    found = compared(mesh, mesh)
    assert found.accuracy.max < 1e-5 and found.completeness.max < 1e-5
    assert found.accuracy.share_within == found.completeness.share_within == 1.0
    assert found.share_flipped == 0.0 and found.mesh == found.truth == soundness(*mesh[1:3])


def face_area(mesh):
    a, b, c = mesh.vertices[mesh.faces].transpose(1, 0, 2)
    return np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()


def test_a_plane_that_is_moved_and_a_half_that_is_missing():
    truth = zoo.grid(10, 10.0)
    mesh = zoo.grid(10, 10.0)
    left = mesh.vertices[mesh.faces].mean(1)[:, 0] < 5.0
    found = compare_meshes(
        truth.vertices,
        truth.faces,
        mesh.vertices + np.float32([0, 0, 0.03]),
        mesh.faces[left],
        samples=20000,
    )
    assert np.isclose(found.accuracy.mean, 0.03) and np.isclose(found.accuracy.p95, 0.03)
    assert found.accuracy.share_within == 1.0
    assert abs(found.completeness.share_within - 0.504) < 0.01
    assert np.isclose(found.completeness.max, 5.0, atol=0.02)
    within = compared(truth, mesh, within=HALF)
    assert 1900 < within.accuracy.count < 2100
    reached = compare_meshes(
        truth.vertices, truth.faces, mesh.vertices, mesh.faces[left], reached=left, samples=1000
    )
    assert reached.completeness.share_within == 1.0 and reached.completeness.count == 1000


def test_faces_that_show_the_other_side():
    truth = zoo.grid(10, 10.0)
    faces = truth.faces.copy()
    right = truth.vertices[faces].mean(1)[:, 0] > 7.0
    faces[right] = faces[right][:, ::-1]
    found = compare_meshes(truth.vertices, truth.faces, truth.vertices, faces, samples=20000)
    assert abs(found.share_flipped - right.mean()) < 0.01
    assert found.mesh.inconsistent_edges == 10
    # both sides of a thin wall are there
    both = np.concatenate([truth.faces, truth.faces[:, ::-1]])
    wall = compare_meshes(truth.vertices, both, truth.vertices, faces, samples=2000)
    assert wall.share_flipped == 0.0


def test_soundness():
    found = soundness(*_two_sizes())
    assert (found.components, found.border_loops, found.faces) == (2, 2, 53)
    assert np.isclose(found.share_outside_largest, 4 / 53)
    fan = zoo.fan_of_three()
    assert soundness(fan.vertices, fan.faces).non_manifold_edges == 1


def _two_sizes():
    """A grid with a hole, and a tetrahedron."""
    big, little = zoo.grid(5, 5.0), zoo.tetrahedron(0.2)
    vertices = np.concatenate([big.vertices, little.vertices + 9.0]).astype(np.float32)
    faces = np.concatenate([np.delete(big.faces, 24, 0), little.faces + len(big.vertices)])
    return vertices, faces


def test_samples_are_spread_by_area():
    mesh = terrain()
    points, faces = surface_samples(mesh.vertices, mesh.faces, 50000, np.random.default_rng(3))
    a, b, c = mesh.vertices[mesh.faces].astype(float).transpose(1, 0, 2)
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    counts = np.bincount(faces, minlength=len(mesh.faces))
    assert np.abs(counts - 50000 * areas / areas.sum()).max() <= 2.0  # as each has its own part
    normals = np.cross(b - a, c - a) / areas[:, None]
    assert np.abs(np.einsum("ij,ij->i", points - a[faces], normals[faces])).max() < 1e-6
    again = surface_samples(mesh.vertices, mesh.faces, 50000, np.random.default_rng(3))[0]
    assert np.array_equal(again, points)


@pytest.mark.parametrize(
    "options,text",
    [
        ({"tolerance": 0.0}, "tolerance"),
        ({"samples": 0}, "samples"),
        ({"within": Region(np.full(3, 50.0), np.full(3, 60.0))}, "nothing of the mesh"),
        ({"reached": np.zeros(200, bool)}, "what was reached of the truth has no surface"),
    ],
)
def test_what_cannot_be_measured_is_refused(options, text):
    mesh = zoo.grid(10, 10.0)
    with pytest.raises(MeshMapError, match=text):
        compared(mesh, mesh, **options)
    with pytest.raises(ValueError, match="reached"):
        compared(mesh, mesh, reached=[True])
