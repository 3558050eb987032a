"""Shadows of scans: ground goes on through them, and what may be an opening stays one."""

import numpy as np
import pytest
from meshes import small
from mesh_msgs.world.solids import box, joined

from mesh_map.geometry.border_loops import border_loops
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.geometry.topology import Topology
from mesh_map.reconstruction.options import FieldOptions, SurfaceOptions
from mesh_map.reconstruction.pipeline import Reconstruction
from mesh_map.reconstruction.shadows import fill_shadows
from mesh_map.scans.lidar import LidarModel
from mesh_map.scans.recording import record_scans
from mesh_map.spatial.spatial_index import SpatialIndex

EDGE, SIZE = 0.1, 6.0  # m


def level(x, y):
    return 0.0 * x


def hilly(x, y):
    return 0.15 * np.sin(1.3 * x) * np.cos(0.9 * y) + 0.2 * x


def sheet(height=level, lift=0.0, turned=False):
    """(vertices, faces) of ground over SIZE x SIZE, its front up, or down."""
    count = int(round(SIZE / EDGE)) + 1
    x, y = (each.ravel() for each in np.meshgrid(*[np.arange(count) * EDGE] * 2, indexing="ij"))
    at = np.arange(count * count).reshape(count, count)
    a, b, c, d = (each.ravel() for each in (at[:-1, :-1], at[1:, :-1], at[1:, 1:], at[:-1, 1:]))
    faces = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    faces = faces[:, ::-1] if turned else faces
    return np.float32(np.stack([x, y, height(x, y) + lift], 1)), np.uint32(faces)


def both(*parts):
    """One mesh of several (vertices, faces); places that are the same to 1 mm are one vertex."""
    vertices = np.concatenate([part[0] for part in parts])
    starts = np.cumsum([0] + [len(part[0]) for part in parts])
    faces = np.concatenate([part[1] + np.uint32(at) for part, at in zip(parts, starts)])
    _, first, number = np.unique(
        np.rint(vertices * 1e3), axis=0, return_index=True, return_inverse=True
    )
    return vertices[first], np.uint32(number.ravel()[faces])


def opened(part, low, high):
    """Without the faces whose middle is between two places (x, y)."""
    middles = part[0][part[1]].mean(axis=1)[:, :2]
    return part[0], part[1][~((middles > low) & (middles < high)).all(axis=1)]


def upright(start, end, low, high):
    """A wall of EDGE x EDGE squares from one (x, y) to another, its front to the left of that."""
    start, way = np.array(start), np.subtract(end, start)
    long, tall = int(round(np.linalg.norm(way) / EDGE)), int(round((high - low) / EDGE))
    u, v = (each.ravel() for each in np.meshgrid(range(long + 1), range(tall + 1), indexing="ij"))
    xy = start + np.outer(u / long, way)
    at = np.arange(len(u)).reshape(long + 1, tall + 1)
    a, b, c, d = (each.ravel() for each in (at[:-1, :-1], at[1:, :-1], at[1:, 1:], at[:-1, 1:]))
    faces = np.concatenate([np.stack([c, b, a], 1), np.stack([d, c, a], 1)])
    return np.float32(np.c_[xy, low + v * EDGE]), np.uint32(faces)


def closed(part, max_width=1.0, narrow=0.32):
    """How many shadows are closed; the mesh then is sound."""
    found = fill_shadows(*part, max_width=max_width, narrow=narrow)
    if found.derived is not None:
        derived = found.derived
        topology = Topology(faces=derived.faces, vertex_count=len(derived.vertices))
        assert not topology.non_manifold_edges.any() and not topology.inconsistent_edges.any()
        assert len(derived.faces) == len(part[1]) + found.faces
        assert np.array_equal(derived.faces[: len(part[1])], part[1])
        loops = [border_loops(each, 1 << 20).count for each in (part[1], derived.faces)]
        assert loops[0] - loops[1] == found.holes
    return found.holes


@pytest.mark.parametrize("height", [level, hilly])
def test_ground_goes_on_through_a_shadow(height):
    part = sheet(height)
    for low, high in (((2.0, 2.0), (2.7, 2.8)), ((1.0, 3.0), (5.0, 3.6))):
        holed = opened(part, low, high)
        found = fill_shadows(*holed, max_width=1.0, narrow=0.0)
        assert found.holes == 1 and found.folded == []
        new = found.derived.vertices[len(holed[0]) :]
        off = new[:, 2] - height(new[:, 0], new[:, 1])
        assert len(new) > 20 and np.abs(off).max() < 0.04
    assert closed(opened(part, (2.0, 2.0), (3.2, 3.2))) == 0  # too wide
    assert closed(opened(part, (2.0, 2.0), (3.2, 3.2)), max_width=1.5) == 1


@pytest.mark.parametrize("step, holes", [(0.05, 1), (0.25, 0), (-0.25, 0), (0.4, 0)])
@pytest.mark.parametrize("slope", [0.0, 0.15])
@pytest.mark.parametrize("width", [0.5, 0.9])
def test_the_edge_of_a_curb_is_no_ramp(step, holes, slope, width):
    part = sheet(lambda x, y: slope * x - step * (x > 3.05))
    # What a lidar up there does not see: the upright face, and the ground before it.
    assert closed(opened(part, (2.95, 1.0), (3.0 + width, 5.0))) == holes


def test_a_ditch_of_which_the_far_side_is_seen_stays_open():
    ground = opened(sheet(), (3.0, 1.0), (3.8, 5.0))
    far_side = upright((3.8, 1.0), (3.8, 5.0), -0.3, 0.0)
    assert closed(ground) == 1  # as far as it is known: ground
    assert closed(both(ground, far_side)) == 0


def test_a_pit_stays_open_and_a_hollow_that_is_not_seen_is_ground():
    ground = opened(sheet(), (2.0, 2.0), (2.8, 2.8))
    bottom = sheet(lift=-1.0)
    middles = bottom[0][bottom[1]].mean(axis=1)[:, :2]
    floor = bottom[0], bottom[1][((middles > 1.6) & (middles < 3.2)).all(axis=1)]
    assert closed(both(ground, floor)) == 0
    # what lies below and looks down is the other side of a slab
    slab = sheet(lift=-0.3, turned=True)
    assert closed(both(ground, slab)) == 1
    assert closed(both(ground, slab, bottom)) == 1
    assert closed(both(ground, bottom)) == 0  # a bridge that was not seen from below


def test_a_slit_that_a_wheel_falls_into_stays_open_where_the_ground_below_is_seen():
    below = sheet(lift=-1.0)
    slit = opened(sheet(), (2.0, 1.0), (2.3, 4.0))
    assert closed(both(slit, below)) == 0
    assert closed(slit) == 1


def test_a_window_and_a_stairwell_stay_open():
    def standing(part, at):
        """Turned so that up is towards -x."""
        return np.float32(np.c_[at - part[0][:, 2], part[0][:, 1], part[0][:, 0]]), part[1]

    wall = standing(opened(sheet(), (2.0, 2.0), (2.9, 2.9)), 3.0)
    room = standing(sheet(), 5.0)
    assert closed(both(wall, room)) == 0
    assert closed(wall) == 1
    well = opened(sheet(lift=2.5), (2.0, 2.0), (2.9, 5.0))
    assert closed(both(well, sheet())) == 0


def walls(outside):
    """Those of a wall 0.4 m thick that stands on the ground, or of a ditch in it."""
    corners = [(2.0, 2.0), (2.0, 5.0), (2.4, 5.0), (2.4, 2.0)][:: 1 if outside else -1]
    bottom, top = (0.0, 1.0) if outside else (-0.3, 0.0)
    parts = [upright(a, b, bottom, top) for a, b in zip(corners, corners[1:] + corners[:1])]
    return both(opened(sheet(), (2.0, 2.0), (2.4, 5.0)), *parts)


def test_the_top_of_a_wall_is_closed_and_a_ditch_without_a_bottom_is_not():
    wall = walls(True)
    assert closed(wall) == 1
    found = fill_shadows(*wall, max_width=1.0, narrow=0.32)
    assert np.allclose(found.derived.vertices[len(wall[0]) :, 2], 1.0, atol=1e-3)
    assert closed(walls(False)) == 0


@small
@pytest.mark.parametrize("narrow", [0.0, 5.0])
def test_of_any_mesh_no_fault_is_made(mesh, narrow):
    for faces in (mesh.faces, mesh.faces[::2]):
        found = fill_shadows(mesh.vertices, faces, max_width=1e3, narrow=narrow)
        if found.derived is not None:
            derived = found.derived
            before, after = (
                Topology(faces=each, vertex_count=len(derived.vertices))
                for each in (faces, derived.faces)
            )
            for name in ("non_manifold_edges", "inconsistent_edges", "duplicate_faces"):
                assert getattr(after, name).sum() == getattr(before, name).sum(), name
            assert after.border_edges.sum() < before.border_edges.sum()


def test_what_is_folded_is_named():
    vertices, faces = opened(sheet(), (2.0, 2.0), (2.6, 2.6))
    rim = border_loops(faces, len(vertices))
    loop = min(np.split(rim.vertices, rim.offsets[1:-1]), key=len)
    turned = vertices.copy()  # one vertex of the rim lies back over the ground
    turned[loop[2]] += vertices[loop[2]] - vertices[loop].mean(axis=0)
    turned[loop[2], 2] += 0.01
    found = fill_shadows(turned, faces, max_width=1.0, narrow=0.32)
    assert found.derived is None and [set(each) for each in found.folded] == [set(loop)]


def test_a_pit_and_a_trench_of_a_scanned_yard_stay_open_and_shadows_close():
    pit, trench = ((3.0, 3.0), (3.9, 3.9)), ((5.5, 1.5), (6.3, 6.5))
    rims = [0.0, 3.0, 3.9, 5.5, 6.3, 8.0], [0.0, 1.5, 3.0, 3.9, 6.5, 8.0]
    parts = [box((2.0, 5.6, 0.0), (2.6, 6.2, 0.5)), box((1.2, 2.0, 0.0), (1.5, 2.3, 1.0))]
    for x0, x1 in zip(rims[0], rims[0][1:]):
        for y0, y1 in zip(rims[1], rims[1][1:]):
            middle = np.array([x0 + x1, y0 + y1]) / 2
            sunk = [(np.array(a) < middle).all() and (middle < b).all() for a, b in (pit, trench)]
            depth = 0.7 if any(sunk) else 0.0
            parts.append(box((x0, y0, -1.0), (x1, y1, -depth)))
    vertices, faces = joined(*parts)
    world = MeshGeometry(np.float32(vertices), np.uint32(faces))
    places = [(1.0, 1.0), (1.0, 4.5), (3.0, 7.0), (4.6, 5.0), (4.6, 1.5)]
    poses = np.tile(np.eye(4), (len(places), 1, 1))
    poses[:, :2, 3], poses[:, 2, 3] = places, 0.9
    lidar = LidarModel(rings=64, columns=512, lowest=-0.9, highest=0.2, noise=0.005)
    made = Reconstruction(FieldOptions())
    for each in record_scans(world, poses, lidar=lidar, seed=0):
        made.add(each.scan)
    spots = np.random.default_rng(0).uniform(0.2, 7.8, (4000, 2))
    origins = np.c_[spots, np.full(len(spots), 5.0)]

    def heights(**options):
        mesh = made.surface(SurfaceOptions(min_component=100, **options))[0]
        index = SpatialIndex(mesh.vertices, mesh.faces)
        hits = index.cast_batch(origins=origins, directions=np.tile([0, 0, -1.0], (4000, 1)))
        return 5.0 - hits.distances, border_loops(mesh.faces, len(mesh.vertices)).count

    (before, many), (after, few) = heights(fill_shadows=0.0), heights()
    assert few < many
    true = (
        5.0
        - world.spatial_index.cast_batch(
            origins=origins, directions=np.tile([0, 0, -1.0], (4000, 1))
        ).distances
    )
    sunk = true < -0.3
    for low, high in (pit, trench):  # well inside, nothing hovers
        inside = ((spots > np.array(low) + 0.2) & (spots < np.array(high) - 0.2)).all(axis=1)
        assert inside.sum() > 10 and not (after[inside] > -0.3).any()
    assert not (sunk & (after > -0.1) & ~(before > -0.1)).any()
    ground = np.abs(true) < 0.01
    assert (ground & np.isfinite(after)).sum() > (ground & np.isfinite(before)).sum()
    added = ground & np.isfinite(after) & ~np.isfinite(before)
    assert np.abs(after[added]).max() < 0.1
