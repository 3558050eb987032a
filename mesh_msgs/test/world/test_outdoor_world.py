"""The generated outdoor world: sound triangles, one surface, two levels, drivable ways."""

import hashlib
import subprocess
import sys

import numpy as np
import pytest
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components, dijkstra

from mesh_msgs.outdoor_world import outdoor_world
from mesh_msgs.zoo import TRAITS, ZooMesh, outdoor_world as outdoor_world_of_the_zoo

# A slope (degrees) that a robot climbs.
DRIVABLE = 40.0
_WORLDS = {}
_COMPONENTS = {}


def world(faces, seed=0):
    if (faces, seed) not in _WORLDS:
        _WORLDS[faces, seed] = outdoor_world(faces, seed)
    return _WORLDS[faces, seed]


# 600,000 is above the limit where most of the ground is a cut grid.
@pytest.fixture(
    params=[(1_000, 0), (5_000, 4), (20_000, 0), (20_000, 7), (200_000, 0), (600_000, 1)]
)
def mesh(request):
    return world(*request.param)


def corners(mesh):
    return mesh.vertices.astype(np.float64)[mesh.faces]


def normals(mesh):
    a, b, c = corners(mesh).transpose(1, 0, 2)
    return np.cross(b - a, c - a)


def half_edges(faces):
    """Return (3 F, 2): the directed edges of all faces."""
    return faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2).astype(np.int64)


def undirected(faces):
    """Return edges (E, 2), the smaller index first, and how many of the faces have each."""
    ends = np.sort(half_edges(faces), axis=1)
    # One number for each edge sorts much faster than two.
    keys, counts = np.unique(ends[:, 0] << 32 | ends[:, 1], return_counts=True)
    return np.stack([keys >> 32, keys & 0xFFFFFFFF], axis=1), counts


def graph(mesh, faces):
    """Return the edges of the given faces as a symmetric matrix of lengths."""
    a, b = undirected(faces)[0].T
    vertices = mesh.vertices.astype(np.float64)
    length = np.linalg.norm(vertices[a] - vertices[b], axis=1)
    count = len(vertices)
    return coo_matrix((np.r_[length, length], (np.r_[a, b], np.r_[b, a])), (count, count)).tocsr()


def components(mesh):
    """Return the component of each vertex of a world(); 0 is the one of the ground."""
    if id(mesh) not in _COMPONENTS:
        _, labels = connected_components(graph(mesh, mesh.faces), directed=False)
        ground = labels[place(mesh, "start")]
        labels = np.where(labels == ground, 0, np.where(labels == 0, ground, labels))
        _COMPONENTS[id(mesh)] = labels
    return _COMPONENTS[id(mesh)]


def place(mesh, name):
    """Return the index of the vertex of a named place."""
    found = np.flatnonzero((mesh.vertices == np.array(mesh.places[name], dtype="f4")).all(axis=1))
    assert len(found) == 1
    return found[0]


def drivable_graph(mesh):
    normal = normals(mesh)
    upright = normal[:, 2] / np.linalg.norm(normal, axis=1)
    return graph(mesh, mesh.faces[upright > np.cos(np.radians(DRIVABLE))])


def crossings(points, x, y):
    """Return height and direction (+1 up, -1 down) of all faces on a vertical line, upwards.

    `points` (F, 3, 3) are the corners of the faces.
    """
    a, b, c = points[:, :, :2].transpose(1, 0, 2) - [x, y]
    weights = [p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0] for p, q in ((b, c), (c, a), (a, b))]
    up = np.minimum(np.minimum(weights[0], weights[1]), weights[2]) > 0
    down = np.maximum(np.maximum(weights[0], weights[1]), weights[2]) < 0
    hit = up | down
    weights = np.stack(weights, axis=1)[hit]
    z = (weights * points[hit, :, 2]).sum(axis=1) / weights.sum(axis=1)
    order = np.argsort(z)
    return z[order], np.where(up[hit], 1, -1)[order]


def test_form(mesh):
    assert isinstance(mesh, ZooMesh) and mesh.name == "outdoor_world"
    assert mesh.vertices.dtype == np.float32 and mesh.vertices.shape[1:] == (3,)
    assert mesh.faces.dtype == np.uint32 and mesh.faces.shape[1:] == (3,)
    assert mesh.colors.dtype == np.uint8 and mesh.colors.shape == mesh.vertices.shape
    assert mesh.vertices.flags.c_contiguous and mesh.faces.flags.c_contiguous
    assert mesh.traits < set(TRAITS)
    assert outdoor_world_of_the_zoo is outdoor_world


@pytest.mark.parametrize("faces", [1_000, 1_777, 5_000, 20_000, 200_000, 600_000])
def test_number_of_faces(faces):
    assert len(world(faces).faces) == pytest.approx(faces, rel=0.02)


def test_many_seeds():
    """No seed puts two structures on each other, and small worlds too have the faces asked for."""
    for seed in range(40):
        for faces in (1_000, 3_000):
            assert len(outdoor_world(faces, seed).faces) == pytest.approx(faces, rel=0.02)


def test_faces_are_sound(mesh):
    assert mesh.faces.max() < len(mesh.vertices)
    assert np.isfinite(mesh.vertices).all()
    assert (np.linalg.norm(normals(mesh), axis=1) > 0).all()
    assert len(np.unique(np.sort(mesh.faces, axis=1), axis=0)) == len(mesh.faces)
    assert len(np.unique(mesh.faces)) == len(mesh.vertices), "isolated vertices"
    assert len(np.unique(mesh.vertices, axis=0)) == len(mesh.vertices), "vertices twice"


def test_edges_are_manifold_and_oriented(mesh):
    directed = half_edges(mesh.faces)
    keys = directed[:, 0] << 32 | directed[:, 1]
    assert len(np.unique(keys)) == len(directed), "an edge twice in one direction"
    assert undirected(mesh.faces)[1].max() == 2


def test_vertices_are_manifold(mesh):
    """The corners of faces at a vertex form one fan: joined over edges, one group per vertex."""
    directed = half_edges(mesh.faces)
    # The corner where a directed edge begins; 3 f + i is corner i of face f, and so is its edge.
    begins = np.arange(len(directed))
    ends = begins.reshape(-1, 3)[:, [1, 2, 0]].ravel()
    key = directed[:, 0] * len(mesh.vertices) + directed[:, 1]
    opposite = directed[:, 1] * len(mesh.vertices) + directed[:, 0]
    order = np.argsort(key)
    where = order[np.minimum(np.searchsorted(key, opposite, sorter=order), len(key) - 1)]
    twin = key[where] == opposite
    # Across an edge a -> b, the corners at a are the begin of this and the end of the other side.
    rows, columns = begins[twin], ends[where[twin]]
    count = len(directed)
    links = coo_matrix((np.ones(len(rows)), (rows, columns)), (count, count))
    number, _ = connected_components(links, directed=False)
    assert number == len(mesh.vertices)


def test_ground_walls_trunks_and_bridge_are_one_surface(mesh):
    labels = components(mesh)
    ground = mesh.faces[labels[mesh.faces[:, 0]] == 0]
    edges, counts = undirected(ground)
    characteristic = np.count_nonzero(labels == 0) - len(edges) + len(ground)
    # A disc with one handle, the bridge.
    assert characteristic == 1 - 2
    # Its only boundary is the border of the world, a square.
    rim = mesh.vertices[edges[counts == 1]]
    half = mesh.vertices[labels == 0].max()
    assert (np.abs(rim[:, :, :2]) == half).any(axis=2).all()
    length = np.linalg.norm(np.diff(rim[:, :, :2], axis=1), axis=2).sum()
    assert length == pytest.approx(8 * half, rel=1e-5)


def test_crowns_are_closed_and_look_outwards(mesh):
    labels = components(mesh)
    crowns = np.unique(labels[labels > 0])
    assert len(crowns) >= 3
    of_face, ground = labels[mesh.faces[:, 0]], mesh.vertices[labels == 0]
    for crown in crowns:
        faces = mesh.faces[of_face == crown]
        edges, counts = undirected(faces)
        assert (counts == 2).all()
        assert np.count_nonzero(labels == crown) - len(edges) + len(faces) == 2
        points = mesh.vertices.astype(np.float64)[faces]
        middle = points.mean(axis=(0, 1))
        assert np.linalg.det(points - middle).sum() > 0
        # Each is on a trunk: the surface of the ground reaches into it from below.
        near = np.linalg.norm(ground[:, :2] - middle[:2], axis=1) < 0.3
        low, high = points[:, :, 2].min(), points[:, :, 2].max()
        top = ground[near, 2].max()
        assert low < top < (low + high) / 2


def test_ground_looks_up():
    mesh = world(20_000)
    points = corners(mesh)
    half = mesh.vertices[components(mesh) == 0].max()
    rng = np.random.default_rng(1)
    for x, y in (rng.random((60, 2)) - 0.5) * 1.98 * half:
        z, direction = crossings(points, x, y)
        # From below: ground, then pairs of something's underside and its top.
        assert len(z) % 2 == 1
        assert (direction == np.where(np.arange(len(z)) % 2 == 0, 1, -1)).all()


def test_two_levels_at_the_bridge(mesh):
    x, y, _ = mesh.places["bridge_deck"]
    points = corners(mesh)
    for dx, dy in ((0.013, 0.017), (-1.21, 0.31), (1.37, -0.43)):
        z, direction = crossings(points, x + dx, y + dy)
        assert direction.tolist() == [1, -1, 1], "road, underside of the deck, deck"
        road, below, deck = z
        assert below - road > 2.0, "clearance"
        assert 0.1 < deck - below < 1.0
    assert abs(mesh.places["under_bridge"][0]) < 1.8
    under, deck = mesh.places["under_bridge"], mesh.places["bridge_deck"]
    assert deck[2] - under[2] > 2.0


def test_clearance_over_the_whole_road():
    points = corners(world(200_000))
    points = points[(np.abs(points[:, :, :2]).max(axis=1) < 4.0).all(axis=1)]
    for x in np.linspace(-1.6, 1.6, 9):
        for y in np.linspace(-1.55, 1.55, 7):
            z, _ = crossings(points, x + 1e-3, y + 1e-3)
            assert z[1] - z[0] > 2.0


@pytest.mark.parametrize("faces, seed", [(20_000, 0), (20_000, 5), (200_000, 0), (200_000, 1)])
def test_over_the_bridge_and_under_it(faces, seed):
    """Deck and road are connected by ground that can be driven on, each at both its ends."""
    mesh = world(faces, seed)
    way = drivable_graph(mesh)
    _, labels = connected_components(way, directed=False)
    names = ("start", "goal", "bridge_deck", "under_bridge")
    assert len({labels[place(mesh, name)] for name in names}) == 1
    x, y, z = mesh.vertices.T
    # Within the bridge's own square, the deck leads from west to east, the road from south to
    # north, and nothing leads from one to the other.
    near = (np.abs(x) < 7.0) & (np.abs(y) < 2.5)
    inside = way[near][:, near]
    _, labels = connected_components(inside, directed=False)
    x, y, z = x[near], y[near], z[near]
    deck = labels[np.flatnonzero(near).tolist().index(place(mesh, "bridge_deck"))]
    road = labels[np.flatnonzero(near).tolist().index(place(mesh, "under_bridge"))]
    assert deck != road
    assert x[labels == deck].min() < -6.3 and x[labels == deck].max() > 6.3
    assert y[labels == road].min() < -1.9 and y[labels == road].max() > 1.9
    assert z[labels == deck].min() - z[labels == road].max() > 1.0


@pytest.mark.parametrize("faces, seed", [(20_000, 0), (20_000, 5), (200_000, 0), (200_000, 1)])
def test_the_way_from_start_to_goal(faces, seed):
    mesh = world(faces, seed)
    start, goal = np.array(mesh.places["start"]), np.array(mesh.places["goal"])
    straight = np.linalg.norm(goal - start)
    half = mesh.vertices[components(mesh) == 0].max()
    assert straight > 1.4 * half
    way = drivable_graph(mesh)
    source, target = place(mesh, "start"), place(mesh, "goal")
    distance, before = dijkstra(way, indices=source, return_predecessors=True)
    # Paths along edges of irregular triangles are some percent longer than the shortest.
    assert np.isfinite(distance[target]) and distance[target] > 1.25 * straight
    path = [target]
    while path[-1] != source:
        path.append(before[path[-1]])
    path = mesh.vertices[path]
    on_deck = (np.abs(path[:, :2]) < [1.0, 1.7]).all(axis=1) & (path[:, 2] > 1.0)
    assert on_deck.any(), "the shortest way leads over the bridge"
    # A wall is in the way: the straight line crosses something that rises 1 m within 0.5 m.
    line = start + np.linspace(0, 1, 400)[1:-1, None] * (goal - start)
    points = corners(mesh)
    points = points[(np.abs(points - goal) < 0.25 * straight).all(axis=(1, 2))]
    top = np.array([crossings(points, x, y)[0][-1] for x, y, _ in line[-70:]])
    assert np.ptp(top) > 1.0


def test_places_are_flat_enough():
    for faces, seed in ((20_000, 0), (200_000, 0), (200_000, 1)):
        mesh = world(faces, seed)
        normal = normals(mesh)
        slope = np.degrees(np.arccos(normal[:, 2] / np.linalg.norm(normal, axis=1)))
        for name in mesh.places:
            at = (mesh.faces == place(mesh, name)).any(axis=1)
            assert slope[at].max() < 25.0, name


def test_terrain_is_hilly_and_mostly_drivable():
    for seed in range(3):
        mesh = world(200_000, seed)
        labels = components(mesh)
        ground = labels[mesh.faces[:, 0]] == 0
        normal = normals(mesh)[ground]
        flat = np.abs(normal[:, 2]) / 2
        slope = np.degrees(np.arccos(normal[:, 2] / np.linalg.norm(normal, axis=1)))
        drivable = flat[slope < 30].sum() / flat.sum()
        assert 0.70 < drivable < 0.97
        assert flat[(slope > 35) & (slope < 70)].sum() / flat.sum() > 0.01
        assert 8.0 < np.ptp(mesh.vertices[labels == 0, 2]) < 25.0
        # Vertical walls: a normal without z, on a face as high as a step at least.
        vertical = np.abs(normal[:, 2]) < 1e-3 * np.linalg.norm(normal, axis=1)
        assert np.count_nonzero(vertical) > 2000


@pytest.mark.parametrize("faces, seed", [(200_000, 0), (600_000, 1)])
def test_triangles_are_irregular(faces, seed):
    mesh = world(faces, seed)
    counts = np.bincount(mesh.faces.ravel().astype(np.int64))
    assert len(np.unique(counts)) >= 6
    directed = half_edges(mesh.faces)
    lengths = np.linalg.norm(mesh.vertices[directed[:, 0]] - mesh.vertices[directed[:, 1]], axis=1)
    assert lengths.std() > 0.2 * lengths.mean()
    assert len(np.unique(lengths)) > faces // 2


@pytest.mark.parametrize(
    "faces, side, edge", [(1_000, 24, 1.4), (20_000, 36, 0.5), (200_000, 60, 0.25)]
)
def test_extent_and_edge_length(faces, side, edge):
    mesh = world(faces)
    on_ground = mesh.vertices[components(mesh) == 0]
    assert np.ptp(on_ground[:, :2], axis=0) == pytest.approx(side, rel=0.01)
    directed = half_edges(mesh.faces)
    lengths = np.linalg.norm(mesh.vertices[directed[:, 0]] - mesh.vertices[directed[:, 1]], axis=1)
    assert lengths.mean() == pytest.approx(edge, rel=0.1)


def test_colors_tell_what_is_where():
    mesh = world(200_000)
    red, green, blue = mesh.colors.astype(int).T

    def around(name, radius):
        at = np.array(mesh.places[name])
        return np.linalg.norm(mesh.vertices - at, axis=1) < radius

    labels = components(mesh)
    # Leaves and most of the ground are green, road and bridge gray.
    assert (green[labels > 0] > np.maximum(red, blue)[labels > 0]).mean() > 0.99
    assert (green > np.maximum(red, blue))[labels == 0].mean() > 0.5
    for name in ("under_bridge", "bridge_deck"):
        gray = np.ptp(mesh.colors[around(name, 0.8)].astype(int), axis=1)
        assert gray.max() < 30


def test_same_bytes_in_another_process():
    mesh = world(20_000)
    content = mesh.vertices.tobytes() + mesh.faces.tobytes() + mesh.colors.tobytes()
    content += repr(sorted(mesh.places.items())).encode()
    code = "import hashlib; from mesh_msgs.outdoor_world import outdoor_world; "
    code += "m = outdoor_world(20_000, 0); content = m.vertices.tobytes() + m.faces.tobytes()"
    code += " + m.colors.tobytes() + repr(sorted(m.places.items())).encode(); "
    code += "print(hashlib.sha256(content).hexdigest())"
    result = subprocess.run(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, check=True, universal_newlines=True
    )
    assert result.stdout.strip() == hashlib.sha256(content).hexdigest()


def test_seeds_differ():
    one, two = world(5_000, 4), outdoor_world(5_000, 5)
    assert one.vertices.tobytes() != two.vertices.tobytes()
    assert outdoor_world(5_000, 4).vertices.tobytes() == one.vertices.tobytes()


@pytest.mark.parametrize("faces", [0, 999, 10_000_001, -5, float("nan")])
def test_refuses_other_sizes(faces):
    with pytest.raises(ValueError, match="^outdoor_world: faces = .*, but 1000 to 10000000 are"):
        outdoor_world(faces)


@pytest.mark.parametrize("faces, seed", [(5_000, 1), (60_000, 0), (60_000, 2)])
def test_of_a_given_side_with_stairs_and_without_trees(faces, seed):
    mesh = outdoor_world(faces, seed, size=40.0, trees=False, stairs=True)
    assert len(mesh.faces) == pytest.approx(faces, rel=0.02)
    assert mesh.vertices[:, :2].min(0).tolist() == [-20, -20]
    assert mesh.vertices[:, :2].max(0).tolist() == [20, 20]
    # One oriented manifold surface, whose only border is that of the world.
    edges, counts = undirected(mesh.faces)
    assert counts.max() == 2 and len(np.unique(half_edges(mesh.faces), axis=0)) == 3 * len(
        mesh.faces
    )
    border = mesh.vertices[np.unique(edges[counts == 1])]
    assert (np.abs(border[:, :2]).max(axis=1) == 20).all()
    count = len(mesh.vertices)
    pairs = coo_matrix((np.ones(len(edges)), tuple(edges.T)), (count, count))
    assert connected_components(pairs, directed=False)[0] == 1
    assert np.square(normals(mesh)).sum(axis=1).min() > 0
    # Six steps of 17 cm, in front of the landing.
    x, y, z = mesh.places["landing"]
    ahead = np.abs(mesh.vertices[:, 1] - y) < 0.9
    treads = np.unique(mesh.vertices[ahead & (np.abs(mesh.vertices[:, 0] - x) < 4.0), 2].round(4))
    steps = z - 0.17 * np.arange(6)
    assert np.abs(treads[:, None] - steps).min(axis=0).max() < 0.02


def test_refuses_other_sides():
    for size in (23.0, 101.0, float("nan")):
        with pytest.raises(ValueError, match="^outdoor_world: size = .*, but 24 to 100 m are"):
            outdoor_world(1_000, size=size)
    with pytest.raises(ValueError, match="^outdoor_world: size = 24.0, but 38 to 100 m are"):
        outdoor_world(1_000, stairs=True)
