"""Statistics of what is around vertices, against plain Python."""

import threading

import numpy as np
import pytest
import surroundings
from mesh_map import _kernels
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.geometry.radius_pass import KEPT, RadiusPass
from meshes import BOTANICAL, TestMesh, data_mesh, renumbered, small, soup, terrain

NAMES = ("height_difference", "roughness", "ridge")
NAMES += ("height_difference_around", "roughness_around")
NAMES += ("surface_height_difference", "surface_height_difference_around")


def geometry(mesh, **options):
    return MeshGeometry(mesh.vertices, mesh.faces, **options)


def results(of, radius, search="automatic"):
    radius_pass = RadiusPass(of, radius, search)
    radius_pass.request(*NAMES)
    return [getattr(radius_pass, name)() for name in NAMES]


def check(mesh, radius, **options):
    of = geometry(mesh, **options)
    around = surroundings.neighborhoods(mesh, radius)
    angles = surroundings.mean_edge_angles(mesh, of.vertex_normals)
    expected = (
        surroundings.height_differences(mesh, around, of.up),
        surroundings.roughness(around, angles),
        surroundings.ridge(mesh, of.vertex_normals, around),
        surroundings.height_differences(mesh, around, of.up, own=False),
        surroundings.roughness(around, angles, own=False),
    )
    found = results(of, radius)
    size = np.abs(mesh.vertices).max()
    for name, ours, plain in zip(NAMES, found, expected):
        tolerance = 1e-6 * size + 1e-6 if name.startswith("height") else 2e-6
        np.testing.assert_allclose(ours, plain, rtol=2e-6, atol=tolerance, err_msg=name)
        assert ours.dtype == np.float32 and not ours.flags.writeable


@small
@pytest.mark.parametrize("radius", [0.3, 1.0])
def test_equals_plain_python(mesh, radius):
    check(mesh, radius)


def test_equals_plain_python_on_terrain():
    check(terrain(), 0.3)
    check(terrain(25), 0.6, up_direction=(1, -2, 3), normals="angle")


@small
@pytest.mark.parametrize("radius", [0.3, 1.0])
def test_the_surface_of_large_faces_as_samples_have_it(mesh, radius):
    check_surface(mesh, radius)


@pytest.mark.parametrize("radius", [0.03, 0.06, 0.11])
def test_the_surface_of_a_terrain_with_some_or_only_large_faces(radius):
    check_surface(terrain(12), radius)


def check_surface(mesh, radius):
    of = geometry(mesh)
    ours = dict(zip(NAMES, results(of, radius)))
    around = surroundings.neighborhoods(mesh, radius)
    z = mesh.vertices[:, 2].astype(np.float64)
    lowest, highest, slack = surroundings.surface_heights(mesh, around, radius)
    large = np.isfinite(lowest)
    for own, name in ((True, "height_difference"), (False, "height_difference_around")):
        found = ours["surface_" + name]
        assert np.array_equal(found[~large], ours[name][~large], equal_nan=True)
        assert not (found < ours[name]).any() and not np.isnan(found[large]).any()
        low, high = lowest.copy(), highest.copy()
        for v in np.flatnonzero(large):
            rows = np.append(around[v], v) if own else around[v]
            low[v], high[v] = z[rows].min(initial=low[v]), z[rows].max(initial=high[v])
        sampled = (high - low)[large]
        tolerance = 1e-5 * max(1.0, np.abs(mesh.vertices).max())
        assert (found[large] >= sampled - tolerance).all(), name
        assert (found[large] <= sampled + 6 * slack[large] + tolerance).all(), name


def test_a_step_of_one_row_of_faces():
    """A ledge of 1 m in a grid of 0.2 m: its ends are farther from each other than the radius."""
    row, y = (0.2 * grid.ravel() for grid in np.mgrid[:20, :20])
    x = np.where(np.isclose(row, 2.0), 1.801, row)  # as good as upright
    points = np.stack([x, y, np.where(row > 1.9, 1.0, 0.0)], 1)
    mesh = TestMesh("ledge", points.astype(np.float32), terrain(20).faces)
    of = geometry(mesh).radius_pass(0.3)
    assert not of.height_difference().any()
    found = of.surface_height_difference()
    rim = np.isclose(x, 1.8, atol=0.02)
    np.testing.assert_allclose(found[rim], 0.3, atol=0.001)
    assert np.array_equal(found > 0.0, np.isclose(x, 1.8, atol=0.29))  # those within the radius
    second = np.isclose(x, 1.6)
    np.testing.assert_allclose(found[second], np.sqrt(0.3**2 - 0.2**2), atol=0.02)


def test_a_zigzag_wall_whose_edges_are_all_nearly_level():
    """Its faces are upright, though no side rises by more than 0.06 m within the radius."""
    along = np.arange(0, 100, 5.0)
    top = (np.arange(len(along)) % 2).astype(float)
    points = np.stack([along, 0 * along, top], 1).astype(np.float32)
    faces = [[k, k + 1, k + 2] for k in range(len(along) - 2)]
    of = geometry(TestMesh("zigzag", points, np.array(faces, np.uint32))).radius_pass(0.3)
    inner = of.surface_height_difference()[1:-1]
    np.testing.assert_allclose(inner, 0.3, atol=1e-6)


@pytest.mark.parametrize("radius", [0.1, 0.3, 0.5, 0.8])
def test_searches_agree_to_the_last_bit(radius):
    for mesh in (terrain(60), soup(6, 60, 300), data_mesh(BOTANICAL)):
        of = geometry(mesh)
        for edges, grid in zip(results(of, radius, "edges"), results(of, radius, "grid")):
            assert np.array_equal(edges, grid, equal_nan=True)


def test_the_order_of_vertices_does_not_matter():
    mesh = terrain(50)
    other, new = renumbered(mesh)
    for radius in (0.3, 0.7):
        for ours, theirs in zip(results(geometry(mesh), radius), results(geometry(other), radius)):
            assert np.array_equal(ours, theirs[new], equal_nan=True)


def test_a_plane_is_smooth():
    """Exactly where it is level; coordinates on a slope are rounded."""
    flat = terrain(20)
    x, y = flat.vertices[:, 0], flat.vertices[:, 1]
    level = TestMesh("level", np.stack([x, y, 0 * x], 1), flat.faces)
    assert not results(geometry(level), 0.3)[0].any() and not results(geometry(level), 0.3)[1].any()
    slope = TestMesh("slope", np.stack([x, y, 0.75 * x], 1), flat.faces)
    assert results(geometry(slope), 0.3)[1].max() < 1e-5


def test_a_turn_around_the_up_direction_changes_nothing():
    mesh = terrain(30)
    angle = 0.7
    turn = np.array(
        [[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]]
    )
    moved = TestMesh("moved", (mesh.vertices @ turn.T + (5, -3, 2)).astype(np.float32), mesh.faces)
    for ours, theirs in zip(results(geometry(mesh), 0.35), results(geometry(moved), 0.35)):
        np.testing.assert_allclose(ours, theirs, rtol=1e-3, atol=2e-5)


def test_heights_are_along_up():
    mesh = terrain(30)
    on_its_side = TestMesh("side", mesh.vertices[:, [2, 0, 1]].copy(), mesh.faces)
    expected = geometry(mesh).radius_pass(0.3).height_difference()
    found = geometry(on_its_side, up_direction=(7, 0, 0)).radius_pass(0.3).height_difference()
    assert np.array_equal(found, expected)


def test_one_pass_for_all_that_was_requested(monkeypatch):
    wanted = []
    kernel = _kernels._radius_statistics
    monkeypatch.setattr(
        _kernels, "_radius_statistics", lambda *a: wanted.append(a[10]) or kernel(*a)
    )
    of = geometry(terrain(10))
    of.radius_pass(0.3).request("roughness")
    of.radius_pass(0.3).request("height_difference")
    of.radius_pass(0.3).roughness()
    of.radius_pass(0.3).height_difference()
    assert wanted == [3]
    of.radius_pass(0.3).ridge()
    of.radius_pass(0.3).ridge()
    assert wanted == [3, 4]
    of.radius_pass(0.4).roughness()
    assert wanted == [3, 4, 2]
    of.radius_pass(0.5).request("roughness", "height_difference", "roughness_around")
    of.radius_pass(0.5).height_difference_around()
    of.radius_pass(0.5).roughness_around()
    assert wanted == [3, 4, 2, 27]


def test_alone_or_with_others_a_statistic_is_the_same():
    of = geometry(terrain(30))
    together = dict(zip(NAMES, results(of, 0.3)))
    for search in ("edges", "grid"):
        for name in NAMES:
            alone = getattr(RadiusPass(of, 0.3, search), name)()
            assert np.array_equal(alone, together[name], equal_nan=True), name


def test_threads_wait_for_each_other():
    of = geometry(terrain(60))
    found = []
    threads = [
        threading.Thread(target=lambda: found.append(of.radius_pass(0.3).roughness()))
        for _ in range(4)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(found) == 4 and all(array is found[0] for array in found)


def test_the_last_radii_are_kept():
    pass_of = geometry(terrain(5)).radius_pass
    first, second = pass_of(0.1), pass_of(0.2)
    for radius in range(1, KEPT):
        assert pass_of(0.1) is first
        pass_of(radius)
    assert pass_of(0.1) is first and pass_of(0.2) is not second


def test_wrong_arguments():
    of = geometry(terrain(5))
    for radius in (0.0, -1.0, float("nan")):
        with pytest.raises(ValueError, match="the radius is .*, but it has to be above 0"):
            of.radius_pass(radius)
    with pytest.raises(ValueError, match="'sharpness' is none of height_difference, roughness"):
        of.radius_pass(0.3).request("sharpness")
    with pytest.raises(ValueError, match="search is 'magic', but it has to be automatic, edges or"):
        RadiusPass(of, 0.3, "magic")


def test_the_kernel_checks_its_arrays():
    mesh = soup(5, 200, 150)
    t = geometry(mesh).topology
    angles, normals = np.zeros(200, np.float32), np.zeros((200, 3), np.float32)
    up = np.array((0, 0, 1.0))
    rows = [t.neighbor_offsets, t.neighbors, mesh.faces, t.vertex_face_offsets, t.vertex_faces]
    good = [mesh.vertices, *rows, angles, normals, up, 0.3, 127, "grid"]
    for position, bad, message in (
        (0, mesh.vertices.astype(np.float64), "vertices has to be an array of float32, not of"),
        (0, mesh.vertices[:, :2], r"vertices has to have the shape \(N, 3\)"),
        (0, mesh.vertices[::2], "vertices has to be contiguous"),
        (0, mesh.vertices[:-1].copy(), "neighbors has the index"),
        (0, mesh.vertices[0], r"vertices has to have the shape \(N, 3\)"),
        (1, t.neighbor_offsets[:-1].copy(), "offsets do not divide neighbors into rows"),
        (1, t.neighbor_offsets[::-1].copy(), "offsets do not divide neighbors into rows"),
        (2, t.neighbors + np.uint32(200), "neighbors has the index"),
        (3, mesh.faces + np.uint32(200), "faces has the index"),
        (3, mesh.faces[:-1].copy(), "vertex_faces has the index"),
        (4, t.vertex_face_offsets[:-1].copy(), "offsets do not divide vertex_faces into rows"),
        (5, t.vertex_faces + np.uint32(150), "vertex_faces has the index"),
        (6, angles[1:], r"angles has to have the shape \(200\)"),
        (7, normals[1:], r"normals has to have the shape \(200, 3\)"),
        (8, up[1:], r"up has to have the shape \(3\)"),
        (9, 0.0, "the radius has to be above 0"),
        (9, float("nan"), "the radius has to be above 0"),
        (11, "magic", "search has to be automatic, edges or grid"),
    ):
        arguments = list(good)
        arguments[position] = bad
        with pytest.raises(ValueError, match=message):
            _kernels._radius_statistics(*arguments)
