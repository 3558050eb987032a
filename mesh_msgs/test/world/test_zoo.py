"""Every trait of every mesh of the zoo, computed again from its faces alone."""

import hashlib
import subprocess
import sys
from collections import Counter, defaultdict

import numpy as np
import pytest

from mesh_msgs import zoo

MESHES = {mesh.name: mesh for mesh in zoo.all_meshes()}


@pytest.fixture(params=sorted(MESHES))
def mesh(request):
    return MESHES[request.param]


def half_edges(mesh):
    """Return how often each directed edge (a, b) is run through."""
    faces = mesh.faces.tolist()
    return Counter((f[i], f[(i + 1) % 3]) for f in faces for i in range(3))


def edges(mesh):
    """Return how many faces each undirected edge belongs to."""
    result = Counter()
    for (a, b), count in half_edges(mesh).items():
        result[min(a, b), max(a, b)] += count
    return result


def groups(count, links):
    """Return the connected groups of 0 .. count - 1 as a list of sets."""
    parent = list(range(count))

    def root(i):
        while parent[i] != i:
            parent[i] = parent[parent[i]]
            i = parent[i]
        return i

    for a, b in links:
        parent[root(a)] = root(b)
    result = defaultdict(set)
    for i in range(count):
        result[root(i)].add(i)
    return list(result.values())


def euler(mesh):
    return len(mesh.vertices) - len(edges(mesh)) + len(mesh.faces)


def boundary_loops(mesh):
    rim = [edge for edge, count in edges(mesh).items() if count == 1]
    used = sorted({vertex for edge in rim for vertex in edge})
    number = {vertex: i for i, vertex in enumerate(used)}
    return len(groups(len(used), [(number[a], number[b]) for a, b in rim]))


def corners(mesh):
    return mesh.vertices.astype(np.float64)[mesh.faces]


def normals(mesh):
    a, b, c = corners(mesh).transpose(1, 0, 2)
    return np.cross(b - a, c - a)


def area(mesh):
    return np.linalg.norm(normals(mesh), axis=1).sum() / 2


def volume(mesh):
    """Return the signed volume of a closed mesh, positive if its faces look outwards."""
    return np.linalg.det(corners(mesh) - mesh.vertices.astype(np.float64).mean(axis=0)).sum() / 6


# --- one function per trait, each by brute force ---


def is_manifold(mesh):
    if any(count > 2 for count in edges(mesh).values()):
        return False
    around = defaultdict(list)
    for face in mesh.faces.tolist():
        for i in range(3):
            around[face[i]].append({face[(i + 1) % 3], face[(i + 2) % 3]})
    for fan in around.values():
        links = [(i, j) for i in range(len(fan)) for j in range(i) if fan[i] & fan[j]]
        if len(groups(len(fan), links)) != 1:
            return False
    return True


def is_orientable(mesh):
    """Try to give every face a side, spreading over shared edges."""
    users = defaultdict(list)
    for number, face in enumerate(mesh.faces.tolist()):
        for i in range(3):
            a, b = face[i], face[(i + 1) % 3]
            users[min(a, b), max(a, b)].append((number, a < b))
    if any(len(pair) > 2 for pair in users.values()):
        return False
    neighbors = defaultdict(list)
    for pair in users.values():
        if len(pair) == 2:
            (one, up), (two, down) = pair
            neighbors[one].append((two, up == down))
            neighbors[two].append((one, up == down))
    side = {}
    for first in range(len(mesh.faces)):
        if first in side:
            continue
        side[first] = False
        todo = [first]
        while todo:
            face = todo.pop()
            for other, flip in neighbors[face]:
                if other not in side:
                    side[other] = side[face] ^ flip
                    todo.append(other)
                elif side[other] != side[face] ^ flip:
                    return False
    return True


def is_planar(mesh):
    centered = mesh.vertices.astype(np.float64)
    if len(centered) == 0:
        return True
    centered = centered - centered.mean(axis=0)
    return bool(np.linalg.svd(centered, compute_uv=False)[-1] < 1e-9)


def levels_above(mesh, x, y):
    """Return the heights at which the vertical line through (x, y) crosses faces that look up."""
    points = corners(mesh)[normals(mesh)[:, 2] > 1e-12]
    a, b, c = points[:, :, :2].transpose(1, 0, 2) - [x, y]
    # Each corner's weight is the area between the point and the opposite side.
    weights = np.stack(
        [p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0] for p, q in ((b, c), (c, a), (a, b))], axis=1
    )
    hit = weights.min(axis=1) > 1e-12
    weights = weights[hit]
    return ((weights * points[hit, :, 2]).sum(axis=1) / weights.sum(axis=1)).tolist()


def is_multi_level(mesh):
    middles = corners(mesh).mean(axis=1)[:, :2] + [1e-4, 2.3e-4]
    upward = middles[normals(mesh)[:, 2] > 0]
    return any(np.ptp(levels_above(mesh, x, y) or [0.0]) > 1e-6 for x, y in upward)


def is_degenerate(mesh):
    for a, b, c in corners(mesh):
        longest = max(np.linalg.norm(b - a), np.linalg.norm(c - b), np.linalg.norm(a - c))
        if np.linalg.norm(np.cross(b - a, c - a)) <= longest * longest / 1000:
            return True
    return any(len(set(face)) < 3 for face in mesh.faces.tolist())


CHECKS = {
    "empty": lambda m: len(m.vertices) == 0 and len(m.faces) == 0,
    "closed": lambda m: len(m.faces) > 0 and 1 not in edges(m).values(),
    "boundary": lambda m: 1 in edges(m).values(),
    "manifold": is_manifold,
    "oriented": lambda m: all(count == 1 for count in half_edges(m).values()),
    "orientable": is_orientable,
    "connected": lambda m: len(groups(len(m.vertices), edges(m))) == 1,
    "planar": is_planar,
    "upward": lambda m: len(m.faces) > 0 and bool((normals(m)[:, 2] > 0).all()),
    "multi_level": is_multi_level,
    "degenerate": is_degenerate,
    "isolated_vertices": lambda m: len(set(m.faces.ravel().tolist())) < len(m.vertices),
    "duplicate_vertices": lambda m: len(set(map(tuple, m.vertices.tolist()))) < len(m.vertices),
    "duplicate_faces": lambda m: len({frozenset(f) for f in m.faces.tolist()}) < len(m.faces),
    "far": lambda m: bool((np.linalg.norm(m.vertices, axis=1) > 1e5).all()) and len(m.faces) > 0,
}


def test_every_trait_has_a_check():
    assert set(CHECKS) == set(zoo.TRAITS)


@pytest.mark.parametrize("trait", sorted(zoo.TRAITS))
def test_trait_is_listed_exactly_where_it_is_true(mesh, trait):
    assert CHECKS[trait](mesh) == (trait in mesh.traits)


@pytest.mark.parametrize("trait", sorted(zoo.TRAITS))
def test_trait_tells_meshes_apart(trait):
    having = [name for name in MESHES if trait in MESHES[name].traits]
    assert 0 < len(having) < len(MESHES)


def test_form(mesh):
    assert mesh.vertices.dtype == np.float32 and mesh.vertices.shape[1:] == (3,)
    assert mesh.faces.dtype == np.uint32 and mesh.faces.shape[1:] == (3,)
    assert mesh.vertices.flags.c_contiguous and mesh.faces.flags.c_contiguous
    assert np.isfinite(mesh.vertices).all()
    assert (mesh.faces < len(mesh.vertices)).all()
    assert isinstance(mesh.traits, frozenset)
    assert mesh.colors is None and mesh.places == {}


def test_names():
    meshes = zoo.all_meshes()
    assert len(MESHES) == len(meshes)
    for mesh in meshes:
        again = getattr(zoo, mesh.name)()
        assert again.vertices.tobytes() == mesh.vertices.tobytes()
        assert again.faces.tobytes() == mesh.faces.tobytes()
        assert callable(getattr(zoo, mesh.name))


def test_calls_share_nothing():
    first = zoo.grid()
    first.vertices[:] = 7
    assert zoo.grid().vertices.max() == 10 and zoo.grid().vertices.min() == 0


def test_same_bytes_in_another_process():
    def digest():
        parts = [mesh.vertices.tobytes() + mesh.faces.tobytes() for mesh in zoo.all_meshes()]
        return hashlib.sha256(b"".join(parts)).hexdigest()

    code = "import hashlib; from mesh_msgs import zoo; print(hashlib.sha256(b''.join("
    code += "m.vertices.tobytes() + m.faces.tobytes() for m in zoo.all_meshes())).hexdigest())"
    result = subprocess.run(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, check=True, universal_newlines=True
    )
    assert result.stdout.strip() == digest()


@pytest.mark.parametrize(
    "name, characteristic, loops",
    [
        ("tetrahedron", 2, 0),
        ("grid", 1, 1),
        ("jittered_plane", 1, 1),
        ("sphere", 2, 0),
        ("torus", 0, 0),
        ("two_storeys", 1, 1),
        ("hole", 0, 2),
        ("two_components", 2, 2),
        ("moebius_strip", 0, 1),
        ("sliver", 1, 1),
        ("duplicate_vertex", 2, 2),
        ("isolated_vertex", 2, 1),
        ("far_sphere", 2, 0),
        ("empty", 0, 0),
    ],
)
def test_topology(name, characteristic, loops):
    assert euler(MESHES[name]) == characteristic
    assert boundary_loops(MESHES[name]) == loops


def test_bow_tie_has_two_fans_at_one_vertex():
    mesh = zoo.bow_tie()
    assert max(edges(mesh).values()) == 1
    assert Counter(mesh.faces.ravel().tolist()).most_common(1) == [(0, 2)]


def test_fan_of_three():
    assert sorted(edges(zoo.fan_of_three()).values()) == [1] * 6 + [3]


def test_areas_of_plane_meshes():
    assert area(zoo.grid(7, 3.5)) == pytest.approx(3.5**2)
    assert area(zoo.jittered_plane(20, 4.0, seed=3)) == pytest.approx(16.0, rel=1e-6)
    assert area(zoo.hole(9, 9.0)) == pytest.approx(81.0 - 9.0)
    assert area(zoo.two_components(5, 2.0, 0.5)) == pytest.approx(8.0)
    assert area(zoo.sliver(1e-5, 2.0)) == pytest.approx(2.0)


def test_jittered_plane_is_irregular():
    mesh = zoo.jittered_plane(20, 20.0)
    areas = np.linalg.norm(normals(mesh), axis=1) / 2
    assert areas.std() > 0.1 and len(np.unique(areas)) > 700
    valences = Counter(mesh.faces.ravel().tolist()).values()
    assert len(set(valences)) >= 5
    assert zoo.jittered_plane(20, 20.0, seed=1).vertices.tobytes() != mesh.vertices.tobytes()


def test_tetrahedron_measures():
    mesh = zoo.tetrahedron(2.0)
    lengths = [np.linalg.norm(mesh.vertices[a] - mesh.vertices[b]) for a, b in edges(mesh)]
    assert lengths == pytest.approx([2.0] * 6)
    assert volume(mesh) == pytest.approx(8.0 / (6 * np.sqrt(2)), rel=1e-6)


def test_sphere_approaches_the_analytic_sphere():
    errors = []
    for subdivisions in (2, 3, 4):
        mesh = zoo.sphere(subdivisions, 3.0)
        assert len(mesh.faces) == 20 * 4**subdivisions
        assert np.linalg.norm(mesh.vertices, axis=1) == pytest.approx(3.0, rel=1e-6)
        errors.append(
            [1 - area(mesh) / (36 * np.pi), 1 - volume(mesh) / (36 * np.pi)],
        )
    errors = np.array(errors)
    assert (errors > 0).all() and (errors[-1] < [0.003, 0.006]).all()
    # Both are of second order: a quarter per subdivision.
    assert errors[1:] / errors[:-1] == pytest.approx(0.25, abs=0.02)


def test_torus_approaches_the_analytic_torus():
    mesh = zoo.torus(96, 48, 2.0, 0.5)
    assert area(mesh) == pytest.approx(4 * np.pi**2 * 2.0 * 0.5, rel=0.003)
    assert volume(mesh) == pytest.approx(2 * np.pi**2 * 2.0 * 0.25, rel=0.006)
    assert volume(mesh) > 0
    ring = np.hypot(mesh.vertices[:, 0], mesh.vertices[:, 1]) - 2.0
    assert np.hypot(ring, mesh.vertices[:, 2]) == pytest.approx(0.5, rel=1e-5)


def test_closed_meshes_look_outwards(mesh):
    if "closed" in mesh.traits:
        assert volume(mesh) > 0


@pytest.mark.parametrize("cells, size, height", [(6, 6.0, 2.0), (12, 12.0, 3.0), (25, 10.0, 2.5)])
def test_two_storeys(cells, size, height):
    mesh = zoo.two_storeys(cells, size, height)
    assert euler(mesh) == 1 and boundary_loops(mesh) == 1 and is_manifold(mesh)
    assert len(groups(len(mesh.vertices), edges(mesh))) == 1
    middle = (np.arange(cells) + 0.4) * size / cells
    for x in middle:
        for y in middle[:: max(1, cells // 6)] + 0.01 * size / cells:
            levels = sorted(levels_above(mesh, x, y))
            assert levels == pytest.approx([0.0, height], abs=1e-6)
    # Walkable everywhere: no face steeper than 45 degrees.
    normal = normals(mesh)
    assert (normal[:, 2] / np.linalg.norm(normal, axis=1)).min() > np.cos(np.pi / 4)
    # Between the floors there is a ramp, beside them.
    z = mesh.vertices[:, 2]
    between = mesh.vertices[(z > 0.01) & (z < height - 0.01)]
    assert len(between) > 0 and between[:, 1].min() >= size - 1e-5
    with pytest.raises(ValueError, match="^two_storeys: cells = 5, but at least 6 are needed$"):
        zoo.two_storeys(5)


def test_moebius_strip_has_one_side():
    for around, across in ((12, 1), (24, 3), (25, 4)):
        mesh = zoo.moebius_strip(around, across)
        assert is_manifold(mesh) and not is_orientable(mesh)
        assert euler(mesh) == 0 and boundary_loops(mesh) == 1


def test_far_sphere_is_where_it_is_said():
    mesh = zoo.far_sphere(1e6, radius=10.0)
    assert mesh.vertices.mean(axis=0, dtype=np.float64) == pytest.approx([1e6, 1e6, 0], abs=0.1)
    away = np.linalg.norm(mesh.vertices.astype(np.float64) - [1e6, 1e6, 0], axis=1)
    assert away == pytest.approx(10.0, abs=0.05)
