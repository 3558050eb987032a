"""Walks that begin exactly at a vertex or on an edge, or lead through one: where the floor goes on,
so do they, and where it ends, they say so.
"""

from functools import lru_cache

import numpy as np
import pytest
from mesh_map.geometry.topology import Topology
from mesh_map.geometry.walk import SurfaceWalker, WalkEnd
from mesh_map.spatial.hits import SurfacePoint
from mesh_msgs import zoo
from meshes import BOTANICAL, SMALL, TRAY, TestMesh, data_mesh, terrain
from walk_oracle import Around, faces_at

HEADINGS = 13
EVERY = [mesh.name for mesh in SMALL] + ["broken_terrain", TRAY, BOTANICAL]
every = pytest.mark.parametrize("name", EVERY)


def broken_terrain(size=16, noise=0.03):
    """Rough ground of which every fifth face is missing: corners of all kinds."""
    mesh = terrain(size)
    random = np.random.default_rng(4)
    kept = random.random(len(mesh.faces)) > 0.2
    vertices = mesh.vertices + random.normal(0, noise, mesh.vertices.shape) * (0, 0, 1)
    return TestMesh("broken_terrain", vertices.astype(np.float32), mesh.faces[kept])


@lru_cache(maxsize=None)
def mesh_of(name):
    if name == "broken_terrain":
        return broken_terrain()
    found = [mesh for mesh in SMALL if mesh.name == name]
    return found[0] if found else data_mesh(name)


@lru_cache(maxsize=None)
def topology_of(mesh):
    return Topology(faces=mesh.faces, vertex_count=len(mesh.vertices))


@lru_cache(maxsize=None)
def walker_of(mesh):
    return SurfaceWalker(vertices=mesh.vertices, faces=mesh.faces, topology=topology_of(mesh))


def at_corner(mesh, face, vertex):
    weights = (mesh.faces[face] == vertex).astype(np.float64)
    return SurfacePoint(int(face), mesh.vertices[vertex].astype(np.float64), weights, 0.0)


@lru_cache(maxsize=None)
def corners(mesh, count=100):
    """[(vertex, a face there with an area, what is around)], mostly those of borders and where
    faces meet oddly."""
    topology = topology_of(mesh)
    odd = topology.non_manifold_vertices.copy()
    odd[topology.edges[topology.border_edges]] = True
    used = np.random.default_rng(0).permutation(np.unique(mesh.faces))
    chosen = np.concatenate([used[odd[used]][:count], used[~odd[used]][: count // 5]])
    found = []
    for vertex in chosen.tolist():
        for face in faces_at(mesh)[vertex].tolist():
            if len(set(mesh.faces[face].tolist())) == 3:
                around = Around(mesh, vertex, face)
                if around.has_area[0]:
                    found.append((vertex, face, around))
    return found


def measures(mesh, faces):
    """(N,) the longest side of each face, m, and its height over that."""
    corner = mesh.vertices[mesh.faces[faces]].astype(np.float64)
    longest = np.linalg.norm(corner - np.roll(corner, 1, 1), axis=2).max(1)
    twice_area = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    return longest, np.linalg.norm(twice_area, axis=1) / np.maximum(longest, 1e-30)


def faces_beside(mesh, edge):
    """The faces that have an edge, a set of two vertices."""
    a, b = edge
    return set(faces_at(mesh)[a].tolist()) & set(faces_at(mesh)[b].tolist())


@lru_cache(maxsize=None)
def reach(mesh, vertex):
    """m that are much less than all sides and heights of the faces with an area at a vertex."""
    longest, heights = measures(mesh, faces_at(mesh)[vertex])
    return 1e-3 * heights[heights > 1e-9 * longest].min()


@every
def test_from_a_corner_it_goes_on_where_a_face_contains_the_heading(name):
    mesh = mesh_of(name)
    walker = walker_of(mesh)
    went = ended = 0
    for vertex, face, around in corners(mesh):
        for angle in np.arange(HEADINGS) * 2 * np.pi / HEADINGS + 0.1:
            heading, (containing, maybe) = around.heading(angle), around.containing(angle)
            walk = walker.walk(
                start=at_corner(mesh, face, vertex),
                direction=heading,
                up=around.normal,
                length=reach(mesh, vertex),
                path=True,
            )
            if around.is_surrounded or len(containing):
                assert walk.length > 0, (vertex, face, angle)
                went += 1
            elif not maybe and around.shows_all:
                assert walk.end == WalkEnd.BORDER and walk.length == 0, (vertex, face, angle)
                np.testing.assert_allclose(walk.position, around.origin, rtol=1e-12, atol=1e-12)
                ended += 1
            if len(containing) == 1 and around.is_plain and not around.is_surrounded:
                # straight ahead as seen, in that face
                assert walk.path.faces[0] == containing[0]
                step = walk.path.points[1] - walk.path.points[0]
                step -= around.normal * (step @ around.normal)
                across = step - heading * (step @ heading)
                assert step @ heading > 0
                assert np.linalg.norm(across) < 1e-6 * np.linalg.norm(step) + 1e-12
    assert went > 5
    closed = not topology_of(mesh).border_edges.any()
    assert ended > 5 or closed or name.startswith(("soup", "fan"))


@every
def test_on_an_edge_it_goes_on_to_both_sides_and_along_it(name):
    mesh = mesh_of(name)
    walker = walker_of(mesh)
    sizes, heights = measures(mesh, slice(None))
    has_area = heights > 1e-6 * sizes
    at_edge = {}
    for face, corner in enumerate(mesh.faces.tolist()):
        if has_area[face]:
            for k in range(3):
                edge = frozenset((corner[k], corner[k - 2]))
                at_edge.setdefault(edge, set()).add(frozenset(corner))
    random = np.random.default_rng(1)
    across = ended = 0
    for face in random.permutation(np.flatnonzero(has_area))[:80].tolist():
        corner = mesh.vertices[mesh.faces[face]].astype(np.float64)
        longest = np.linalg.norm(corner - np.roll(corner, 1, 0), axis=1).max()
        normal = np.cross(corner[1] - corner[0], corner[2] - corner[0])
        for a, b in ((0, 1), (1, 2), (2, 0)):
            edge = frozenset(mesh.faces[face, [a, b]].tolist())
            without = [f for f in faces_beside(mesh, edge) if not has_area[f]]
            side = corner[b] - corner[a]
            outward = np.cross(side, normal)
            outward *= np.linalg.norm(side) / np.linalg.norm(outward)
            for share in (0.5, 0.25, 0.9375):
                weights = np.zeros(3)
                weights[[a, b]] = 1 - share, share
                start = SurfacePoint(face, weights @ corner, weights, 0.0)

                def walked(direction, length):
                    return walker.walk(start=start, direction=direction, length=length, up=normal)

                for turn in (-0.9, -0.3, 0.0, 0.3, 0.9):
                    way = np.cos(turn) * outward + np.sin(turn) * side
                    assert walked(-way, 1e-9 * longest).end == WalkEnd.ARRIVED
                    walk = walked(way, 1e-5 * longest)
                    if len(at_edge[edge]) > 1:
                        assert walk.length > 1e-9 * longest
                        across += 1
                    elif not without:
                        assert walk.end == WalkEnd.BORDER and walk.length < 1e-12 * longest
                        ended += 1
                for sign, room in ((1, 1 - share), (-1, share)):
                    walk = walked(sign * side, 0.75 * room * np.linalg.norm(side))
                    goal = start.position + sign * 0.75 * room * side
                    assert walk.end == WalkEnd.ARRIVED
                    assert np.linalg.norm(walk.position - goal) < 1e-9 * (1 + np.abs(corner).max())
    assert across + ended > 10


@every
def test_through_a_corner_it_goes_on_where_a_face_contains_the_way(name):
    mesh = mesh_of(name)
    walker = walker_of(mesh)
    random = np.random.default_rng(2)
    went = ended = 0
    for vertex, face, around in corners(mesh):
        weights = random.dirichlet((2, 2, 2))
        before = weights @ mesh.vertices[mesh.faces[face]].astype(np.float64)
        way = around.origin - before
        distance = np.linalg.norm(way)
        containing, maybe = around.containing(around.angle_of(way))
        walk = walker.walk(
            start=SurfacePoint(face, before, weights, 0.0),
            direction=way,
            up=around.normal,
            length=distance + reach(mesh, vertex),
        )
        if around.is_surrounded or len(containing):
            assert walk.length > distance + 0.5 * reach(mesh, vertex) or walk.end == WalkEnd.BORDER
            assert walk.length > distance * (1 + 1e-12)
            went += 1
        elif not maybe and around.shows_all:
            assert walk.end == WalkEnd.BORDER
            assert np.linalg.norm(walk.position - around.origin) < 1e-9 * (1 + np.abs(before).max())
            ended += 1
        if walk.end == WalkEnd.ARRIVED:
            # a stop at the corner changes nothing
            stop = walker.walk(
                start=SurfacePoint(face, before, weights, 0.0),
                direction=way,
                up=around.normal,
                length=distance,
            )
            on = walker.walk(start=stop, length=reach(mesh, vertex))
            rounding = 1e-6 * reach(mesh, vertex) + 1e-12 * (1 + np.abs(before).max())
            assert np.linalg.norm(on.position - walk.position) < rounding
    assert went + ended > 0


PLAIN = ("grid", "jittered_plane", "sphere", "torus", "two_storeys", "hole", "moebius_strip")
PLAIN += ("broken_terrain",)


@pytest.mark.parametrize("name", PLAIN)
def test_a_mask_blocks_a_walk_and_does_not_bend_it(name):
    mesh = mesh_of(name)
    walker = walker_of(mesh)
    random = np.random.default_rng(3)
    blocked = free_to_the_end = 0
    for vertex, face, around in corners(mesh, 50):
        mask = random.random(len(mesh.faces)) < 0.7
        walk = {
            "start": at_corner(mesh, face, vertex),
            "direction": around.heading(random.uniform(0, 2 * np.pi)),
            "up": around.normal,
            "length": 4e3 * reach(mesh, vertex),
            "path": True,
        }
        free, masked = walker.walk(**walk), walker.walk(**walk, mask=mask)
        count = len(masked.path.faces)
        assert masked.end in (free.end, WalkEnd.BLOCKED)
        assert np.array_equal(masked.path.faces, free.path.faces[:count])
        assert np.array_equal(masked.path.points, free.path.points[: count + 1])
        assert mask[masked.path.faces[1:]].all()
        blocked += masked.end == WalkEnd.BLOCKED
        free_to_the_end += masked.end == free.end and count > 1
    assert blocked > 10 and free_to_the_end > 3


def test_along_an_edge_the_face_on_either_side_will_do():
    grid = zoo.grid(4, 4.0)
    mesh = TestMesh(grid.name, grid.vertices, grid.faces)
    walker = walker_of(mesh)
    middle = mesh.vertices[mesh.faces].astype(np.float64).mean(1)
    for upper in (True, False):
        mask = (middle[:, 1] > 2) == upper
        for face in faces_at(mesh)[12]:  # (2, 2)
            for way, end in (((1, 0, 0), WalkEnd.ARRIVED), ((0, -1, 0), WalkEnd.BLOCKED)):
                sign = 1 if upper else -1
                walk = walker.walk(
                    start=at_corner(mesh, face, 12),
                    direction=np.multiply(way, (1, sign, 1)),
                    length=1.5,
                    mask=mask,
                )
                if end == WalkEnd.BLOCKED and not mask[face]:
                    continue  # it may leave the face in which it is
                assert walk.end == end and walk.length == (1.5 if end == WalkEnd.ARRIVED else 0)


UP = np.array([0.0, 0.0, 1.0])


@lru_cache(maxsize=None)
def seen_from_above(mesh, count=100):
    """[(vertex, a face there that is not upright, what is around)]."""
    found = []
    for vertex, face, around in corners(mesh, count):
        if abs(around.normal @ UP) > 1e-6:
            around = Around(mesh, vertex, face, up=UP)
            if around.in_front[0]:
                found.append((vertex, face, around))
    return found


def rounding_at(mesh, vertex):
    """m: lines begin 1e-9 of a face beside what they are told."""
    corner = mesh.vertices[mesh.faces[faces_at(mesh)[vertex]]].astype(np.float64)
    return 1e-7 * np.ptp(corner, axis=1).max() + 1e-12 * np.abs(corner).max()


@every
def test_from_a_corner_lines_lead_to_all_that_is_around(name):
    """And end where nothing is."""
    mesh = mesh_of(name)
    walker = walker_of(mesh)
    random = np.random.default_rng(5)
    arrived = ended = 0
    for vertex, face, around in seen_from_above(mesh):
        scale = 1e3 * reach(mesh, vertex)
        rounding = rounding_at(mesh, vertex)
        for angle in random.uniform(0, 2 * np.pi, 6):
            found, maybe = around.containing(angle)
            line = {"start": at_corner(mesh, face, vertex), "up": UP}
            if len(found) == 1 and not maybe:
                way = around.way_in(found[0], angle)
                goal = around.origin + 0.3 * scale / np.linalg.norm(way) * way
                walk = walker.line(**line, target=goal)
                assert walk.end == WalkEnd.ARRIVED, (vertex, face, angle)
                assert np.linalg.norm(walk.position - goal) < rounding
                assert abs(walk.length - 0.3 * scale) < rounding
                arrived += 1
            elif not len(found) and not maybe and around.shows_all:
                walk = walker.line(**line, target=around.origin + scale * around.heading(angle))
                assert walk.end == WalkEnd.BORDER, (vertex, face, angle)
                assert np.linalg.norm(walk.position - around.origin) < 1e3 * rounding
                ended += 1
    assert arrived > 0 or name in ("tetrahedron", "fan_of_three")
    assert ended > 0 or name not in ("hole", "two_storeys", "broken_terrain", BOTANICAL)


@every
def test_lines_lead_through_corners(name):
    """From one face at a vertex straight through it to another one."""
    mesh = mesh_of(name)
    walker = walker_of(mesh)
    random = np.random.default_rng(6)
    through = at_border = 0
    for vertex, face, around in seen_from_above(mesh):
        scale = 1e3 * reach(mesh, vertex)
        rounding = rounding_at(mesh, vertex)
        past = random.uniform(0, 1) * around.spread[0]
        behind = around.begin[0] + past
        before, others = around.containing(behind)
        beyond, maybe = around.containing(behind + np.pi)
        if before.tolist() != [face] or others or len(beyond) != 1 or maybe:
            continue
        ways = around.way_in(face, behind), around.way_in(beyond[0], behind + np.pi)
        lengths = np.array([np.linalg.norm(way) for way in ways])
        start, goal = (
            around.origin + 0.3 * scale / length * way for way, length in zip(ways, lengths)
        )
        corner = mesh.vertices[mesh.faces[face]].astype(np.float64)
        weights = np.linalg.lstsq(
            np.vstack([corner.T - around.origin[:, None], np.ones(3)]),
            np.append(start - around.origin, 1),
            rcond=None,
        )[0]
        line = {"start": SurfacePoint(face, start, weights, 0.0), "target": goal, "up": UP}
        walk = walker.line(**line, path=True)
        assert walk.end == WalkEnd.ARRIVED, (vertex, face, behind)
        assert np.linalg.norm(walk.position - goal) < rounding
        assert abs(walk.length - 0.6 * scale) < rounding
        steps = np.linalg.norm(np.diff(walk.path.points, axis=0), axis=1)
        assert abs(steps.sum() - walk.length) < rounding
        assert len(walk.path.points) == len(walk.path.faces) + 1
        through += 1
        at_border += not around.is_surrounded
    assert through > 0 or name.startswith(("bow", "fan", "zero", "duplicate_v", "tetra", "soup"))
    assert at_border > 0 or name not in ("hole", "two_storeys", "broken_terrain", BOTANICAL)


def corner_of_eleven_faces():
    """A border corner of 11 faces on rough ground, over all but 20 degrees around it."""
    random = np.random.default_rng(11)
    angles = np.radians(np.linspace(10, 350, 12))
    ring = np.stack([np.cos(angles), np.sin(angles), random.normal(0, 0.35, 12)], 1)
    vertices = np.concatenate([np.zeros((1, 3)), ring]).astype(np.float32)
    faces = np.array([[0, 1 + k, 2 + k] for k in range(11)], np.uint32)
    return TestMesh("corner", vertices, faces)


def test_a_corner_of_eleven_faces_is_left_in_every_heading_but_the_slit():
    """Its faces together have less than the angle that they fill as seen."""
    mesh = corner_of_eleven_faces()
    walker = walker_of(mesh)
    for face in range(11):
        around = Around(mesh, 0, face)
        for near in (0.0, 1e-11):  # or so near that nobody can tell
            weights = np.full(3, near)
            weights[mesh.faces[face] == 0] = 1 - 2 * near
            start = at_corner(mesh, face, 0)._replace(barycentric=weights)
            for angle in np.arange(72) * np.pi / 36 + 0.01:
                containing, maybe = around.containing(angle)
                walk = walker.walk(start=start, direction=around.heading(angle), length=0.3)
                if len(containing):
                    assert walk.end == WalkEnd.ARRIVED
                    assert near or walk.face in containing
                elif not maybe and around.shows_all and not near:
                    assert walk.end == WalkEnd.BORDER and walk.length == 0


def test_over_a_bow_tie_it_goes_from_one_piece_to_the_other():
    mesh = mesh_of(zoo.bow_tie().name)
    walker = walker_of(mesh)
    for face, sign in ((0, 1), (1, -1)):
        start = SurfacePoint(face, np.array([0.5 * sign, 0.1, 0]), np.array([0.5, 0.2, 0.3]), 0.0)
        start = start._replace(position=start.barycentric @ mesh.vertices[mesh.faces[face]])
        way = -start.position
        walk = walker.walk(start=start, direction=way, length=2 * np.linalg.norm(way))
        assert walk.end == WalkEnd.ARRIVED and walk.face == 1 - face
        np.testing.assert_allclose(walk.position, -start.position, atol=1e-12)
        line = walker.line(start=start, target=-start.position)
        assert line.end == WalkEnd.ARRIVED and line.face == 1 - face
        beside = walker.walk(start=start, direction=way + (0, 1e-6, 0), length=1.0)
        assert beside.end == WalkEnd.BORDER
