"""A field of signed distances, and its surface: exact shapes, and what never depends on chance."""

import numpy as np
import pytest
from mesh_msgs.outdoor_world import outdoor_world

from mesh_map.reconstruction.signed_distance import FieldMemoryError, SignedDistanceField
from mesh_map.spatial.spatial_index import SpatialIndex

BLOCK = 512


def edges_of(faces):
    """(3 F, 2): the directed edges of all faces."""
    return np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])


def check_manifold(faces):
    """No edge has more than two faces, and those have it in opposite directions."""
    assert (faces[:, [0, 1, 2]] != faces[:, [1, 2, 0]]).all()
    directed = edges_of(faces)
    assert len(np.unique(directed, axis=0)) == len(directed)


def check_vertices(faces):
    """Nor do faces meet at a vertex without an edge."""
    fans = {}
    for a, b, c in faces.tolist():
        for vertex, start, end in ((a, b, c), (b, c, a), (c, a, b)):
            fans.setdefault(vertex, {})[start] = end
    for fan in fans.values():  # its faces are one chain, or one ring
        begins = [start for start in fan if start not in fan.values()]
        at, steps = (begins or list(fan))[0], 0
        while at in fan and steps < len(fan):
            at, steps = fan[at], steps + 1
        assert steps == len(fan) and len(begins) <= 1


def surface_bits(surface):
    return [None if array is None else array.tobytes() for array in surface]


def scanned_sphere(seed=0, count=20000, noise=0.0, radius=1.0):
    """Points on a sphere, each seen from outside along its normal or somewhat beside it."""
    random = np.random.default_rng(seed)
    normals = random.standard_normal((count, 3))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    points = radius * normals + noise * random.standard_normal((count, 1)) * normals
    origins = points + 2 * normals + 0.2 * random.standard_normal((count, 3))
    return np.float32(points), np.float32(origins)


def rough_scans(count=3, seed=0):
    """Scans of a rough floor with a box on it, from above."""
    random = np.random.default_rng(seed)
    scans = []
    for k in range(count):
        xy = random.uniform(0, 4, (6000, 2))
        z = 0.1 * np.sin(3 * xy[:, 0]) * np.cos(2 * xy[:, 1]) + 0.01 * random.standard_normal(6000)
        z += 0.4 * ((np.abs(xy - 2) < 0.5).all(1))
        scans.append((np.float32(np.c_[xy, z]), np.float32([1.0 + k, 2.0, 1.5])))
    return scans


def field_of(scans, **more):
    field = SignedDistanceField(voxel_size=0.1, **more)
    for points, origin in scans:
        field.integrate(points, origin)
    return field


@pytest.mark.parametrize("tilt", [0.0, 0.3, 1.2])
def test_a_plane_is_found_where_it_is_and_faces_the_sensor(tilt):
    random = np.random.default_rng(1)
    u, v = np.array([np.cos(tilt), 0, np.sin(tilt)]), np.array([0.0, 1.0, 0.0])
    normal = np.cross(u, v)
    points = random.uniform(-1, 1, (20000, 1)) * u + random.uniform(-1, 1, (20000, 1)) * v
    surface = field_of([(points + 0.037 * normal, 3 * normal + u)]).extract()
    inner = (np.abs(surface.vertices @ u) < 0.8) & (np.abs(surface.vertices @ v) < 0.8)
    assert inner.sum() > 200
    off = np.abs(surface.vertices[inner] @ normal - 0.037)
    assert np.median(off) < 1e-5 and off.max() < 2e-3  # vertices keep off the ends of edges
    assert (surface.normals[inner] @ normal).min() > 0.999
    a, b, c = np.moveaxis(surface.vertices[surface.faces], 1, 0)
    assert (np.cross(b - a, c - a) @ normal > 0).mean() > 0.99
    assert (surface.observations[inner] > 0).all()


@pytest.mark.parametrize("noise", [0.06, 0.08])
def test_noise_moves_a_surface_to_neither_side(noise):
    random = np.random.default_rng(0)
    points = random.uniform(-2, 2, (80000, 3))
    points[:, 2] = noise * random.standard_normal(80000)
    surface = field_of([(points, points + [0.3, 0, 3])]).extract(least_weight=0.5)
    inner = np.abs(surface.vertices) < [1.5, 1.5, 0.15]  # m; without specks beside the surface
    heights = surface.vertices[inner.all(axis=1), 2]
    assert len(heights) > 800 and abs(heights.mean()) < 0.002


def test_a_sphere_is_one_closed_surface():
    surface = field_of([scanned_sphere(count=60000, noise=0.01)]).extract()
    check_manifold(surface.faces)
    check_vertices(surface.faces)
    directed = edges_of(surface.faces)
    assert len(np.unique(np.sort(directed, 1), axis=0)) * 2 == len(directed)  # no border
    edges, vertices = len(directed) // 2, len(np.unique(surface.faces))
    assert vertices - edges + len(surface.faces) == 2 and vertices == len(surface.vertices)
    radii = np.linalg.norm(surface.vertices, axis=1)
    assert np.abs(radii - 1).max() < 0.02 and abs(radii.mean() - 1) < 0.003
    outwards = surface.vertices / radii[:, None]
    assert (np.einsum("ij,ij->i", surface.normals, outwards)).min() > 0.95
    a, b, c = np.moveaxis(surface.vertices[surface.faces].astype(float), 1, 0)
    volume = np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6
    assert volume == pytest.approx(4 / 3 * np.pi, rel=0.02)


def test_a_surface_seen_from_inside_faces_inwards():
    points, _ = scanned_sphere()
    surface = field_of([(points, [0, 0, 0])]).extract()
    assert (np.einsum("ij,ij->i", surface.normals, surface.vertices) < -0.9).all()


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("known", [1.0, 0.97])
def test_whatever_the_values_are_the_surface_is_a_manifold(seed, known):
    random = np.random.default_rng(seed)
    field = SignedDistanceField(voxel_size=0.1)
    places = np.stack(np.meshgrid(*[[-1, 0, 1]] * 3), -1).reshape(-1, 3)
    places = places[random.permutation(27)[: 27 if known == 1 else 20]]
    keys = np.uint64(0)
    for axis in (2, 1, 0):
        keys = (keys << np.uint64(21)) | np.uint64(places[:, axis] + (1 << 20))
    count = len(places) * BLOCK
    values = random.integers(-2, 3, count).astype(np.int16) * np.int16(9000)
    weights = (random.random(count) < known).astype(np.uint16) * np.uint16(1000)
    no_bytes, no_floats = np.zeros(0, np.uint8), np.zeros(0, np.float32)
    state = values, weights, np.zeros(count, np.uint16), no_bytes, no_floats
    field._field._restore(keys, *state, np.zeros(0, np.uint64), no_floats)
    surface = field.extract()
    assert len(surface.faces) > 10000
    check_manifold(surface.faces)
    if known == 1:  # where cubes are missing, others may touch at a vertex
        check_vertices(surface.faces)
    assert np.array_equal(np.unique(surface.faces), np.arange(len(surface.vertices)))
    assert np.isfinite(surface.normals).all()
    assert np.abs(np.linalg.norm(surface.normals, axis=1) - 1).max() < 1e-5
    a, b, c = np.moveaxis(surface.vertices[surface.faces].astype(float), 1, 0)
    assert np.linalg.norm(np.cross(b - a, c - a), axis=1).min() > 1e-6


@pytest.mark.parametrize("carve", [False, True])
def test_the_number_of_threads_changes_no_bit(carve):
    kept = [
        surface_bits(field_of(rough_scans(), threads=threads, carve=carve).extract())
        for threads in (1, 2, 5)
    ]
    assert kept[0] == kept[1] == kept[2]


def test_what_is_extracted_between_changes_no_bit():
    scans = rough_scans(4) + [(s[0] + np.float32([3, 0, 0.2]), s[1]) for s in rough_scans(2, 5)]
    field = SignedDistanceField(voxel_size=0.1)
    for points, origin in scans:
        field.integrate(points, origin)
        last = field.extract()
    assert surface_bits(last) == surface_bits(field_of(scans).extract())
    assert surface_bits(field.extract()) == surface_bits(last)


def test_a_field_that_was_kept_goes_on_as_if_it_had_not_been():
    scans = rough_scans(3)
    random = np.random.default_rng(3)
    kinds = dict(colors=True, intensities=True, carve=True, max_range=30.0)
    whole = SignedDistanceField(voxel_size=0.08, **kinds)
    kept = SignedDistanceField(voxel_size=0.08, **kinds)
    for points, origin in scans:
        colors = random.integers(0, 256, (len(points), 3)).astype(np.uint8)
        more = dict(colors=colors, intensities=random.random(len(points)))
        kept = SignedDistanceField.from_bytes(kept.to_bytes())
        assert whole.integrate(points, origin, **more) == kept.integrate(points, origin, **more)
    assert surface_bits(whole.extract()) == surface_bits(kept.extract())
    assert whole.to_bytes() == kept.to_bytes()


def test_a_damaged_state_is_refused():
    data = field_of(rough_scans(1)).to_bytes()
    random = np.random.default_rng(0)
    damaged = [b"", b"PK", data[: len(data) // 2], data[:-30]]
    for _ in range(20):
        bytes_ = bytearray(data)
        bytes_[random.integers(len(data))] ^= 1 << random.integers(8)
        damaged.append(bytes(bytes_))
    refused = 0
    for one in damaged:
        try:
            SignedDistanceField.from_bytes(one).extract()
        except ValueError as error:
            assert "no state of a signed distance field" in str(error)
            refused += 1
    assert refused >= len(damaged) - 4  # bytes of the archive that nobody reads


def test_points_that_are_no_use_are_counted():
    field = SignedDistanceField(voxel_size=0.1, min_range=0.5, max_range=20.0)
    points = np.float32(
        [[1, 0, 0], [np.nan, 0, 0], [0, np.inf, 0], [0.1, 0, 0], [0, 0, 0], [30, 0, 0], [0, 2, 0]]
    )
    report = field.integrate(points, [0, 0, 0])
    assert report == (2, 2, 2, 1, 0)
    near = SignedDistanceField(voxel_size=0.1)
    tiny = np.random.default_rng(0).uniform(-1e-6, 1e-6, (1000, 3)) + [7, 8, 9]
    assert near.integrate(tiny, [7, 8, 9]) == (0, 0, 1000, 0, 0)  # they have no direction
    far = SignedDistanceField(voxel_size=0.1)
    assert far.integrate([[1e9, 0, 0], [1, 2, 3]], [0, 0, 0]) == (1, 0, 0, 0, 1)
    assert far.integrate(np.zeros((0, 3)), [0, 0, 0]) == (0, 0, 0, 0, 0)
    assert len(SignedDistanceField(voxel_size=1.0).extract().faces) == 0


def test_a_limit_of_memory_keeps_what_there_was():
    scans = rough_scans(2)
    without = field_of(scans[:1])
    field = field_of(scans[:1], memory_limit=without.memory + 20000)
    before = surface_bits(field.extract())
    random = np.random.default_rng(0)
    with pytest.raises(FieldMemoryError, match="MB, more than its limit of"):
        field.integrate(random.uniform(-1e4, 1e4, (100000, 3)), [0, 0, 0])
    assert field.memory < without.memory + 12e6
    assert surface_bits(field.extract()) == before
    again = SignedDistanceField.from_bytes(field.to_bytes())
    assert surface_bits(again.extract()) == before


def test_carving_removes_what_has_gone():
    random = np.random.default_rng(0)
    wall = np.c_[np.full(20000, 4.0), random.uniform(-2, 2, (20000, 2))]
    person = np.c_[np.full(300, 2.0), random.uniform(-0.2, 0.2, (300, 2))]
    counts = []
    for carve in (False, True):
        field = SignedDistanceField(voxel_size=0.1, carve=carve)
        field.integrate(person, [0, 0, 0])
        for _ in range(20):
            field.integrate(wall, [0, 0, 0])
        vertices = field.extract().vertices
        counts.append([int((vertices[:, 0] < 3).sum()), int((vertices[:, 0] > 3.5).sum())])
    assert counts[0][0] > 10 and counts[1][0] == 0
    assert counts[0][1] == counts[1][1] > 1000


def test_colors_and_intensities_are_those_of_the_points_near():
    random = np.random.default_rng(0)
    points = np.c_[random.uniform(-1, 1, (40000, 2)), np.zeros(40000)]
    right = points[:, 0] > 0
    colors = np.where(right[:, None], [200, 40, 90], [10, 220, 90]).astype(np.uint8)
    field = SignedDistanceField(voxel_size=0.1, colors=True, intensities=True)
    field.integrate(points, [0, 0, 3], colors=colors, intensities=np.where(right, 7.5, 1.5))
    surface = field.extract()
    for side, color, intensity in ((1, [200, 40, 90], 7.5), (-1, [10, 220, 90], 1.5)):
        there = surface.vertices[:, 0] * side > 0.2
        assert np.abs(surface.colors[there].astype(int) - color).max() <= 4
        assert np.abs(surface.intensities[there] - intensity).max() < 1e-4
    # Where no ray ended near, vertices have what is beside.
    state = list(field._field._state())
    unseen = random.random(len(state[3])) < 0.7
    state[3][unseen] = 0
    state[4].reshape(-1, 4)[unseen] = 0
    state[5][unseen] = 0
    field._field._restore(*state)
    surface = field.extract()
    assert (surface.observations == 0).sum() > 50
    there = np.abs(surface.vertices[:, 0]) > 0.4
    near = np.where(surface.vertices[:, :1] > 0, [200, 40, 90], [10, 220, 90])
    assert np.abs(surface.colors[there].astype(int) - near[there]).max() <= 4
    expected = np.where(surface.vertices[:, 0] > 0, 7.5, 1.5)
    assert np.abs(surface.intensities - expected)[there].max() < 1e-4
    field = SignedDistanceField(voxel_size=0.1)
    field.integrate(points, [0, 0, 3], colors=colors)
    assert field.extract().colors is None and field.extract().intensities is None


def test_each_point_counts_once_however_many_come_at_a_time():
    random = np.random.default_rng(0)
    points = np.c_[random.uniform(-1, 1, (1200, 2)), np.full(1200, 0.03)]
    shades, strengths = [200, 200, 80], [1.0, 1.0, 4.0]

    def measured(repeats):
        count = len(points)
        colors = np.repeat(np.uint8(shades)[repeats], count)[:, None] * np.ones(3, np.uint8)
        intensities = np.repeat(np.float32(strengths)[repeats], count)
        return dict(colors=colors, intensities=intensities), np.tile(points, (len(repeats), 1))

    surfaces = []
    for calls in ([[0]], [[0], [1], [2]], [[0, 1, 2]]):
        field = SignedDistanceField(voxel_size=0.1, colors=True, intensities=True)
        for repeats in calls:
            more, all_points = measured(repeats)
            field.integrate(all_points, [0, 0, 3], **more)
        surfaces.append(field.extract())
    once, apart, together = surfaces
    assert 2 < np.median(once.observations) < 20
    for surface in (apart, together):
        inner = (np.abs(surface.vertices[:, :2]) < 0.8).all(axis=1)
        assert inner.sum() > 200
        assert np.abs(surface.colors[inner].astype(int) - 160).max() <= 2
        assert np.abs(surface.intensities[inner] - 2).max() < 1e-3
        assert np.median(np.abs(surface.vertices[inner, 2] - 0.03)) < 1e-4
    assert np.array_equal(apart.faces, together.faces)
    assert np.allclose(apart.observations, together.observations, rtol=0.02)
    assert np.median(apart.observations) == pytest.approx(3 * np.median(once.observations), 0.05)


def test_a_world_scanned_from_within_is_near_the_truth():
    world = outdoor_world(5_000)
    index = SpatialIndex(world.vertices, world.faces)
    random = np.random.default_rng(0)
    field = SignedDistanceField(voxel_size=0.1)
    low, high = world.vertices.min(0) + 2, world.vertices.max(0) - 2
    for x, y in random.uniform(low[:2], high[:2], (30, 2)):
        down = index.cast(origin=[x, y, 100], direction=[0, 0, -1])
        place = np.array([x, y, 101 - down.distance])
        directions = random.standard_normal((10000, 3)) * [1, 1, 0.5]
        hits = index.cast_batch(origins=place, directions=directions, max_distance=12.0)
        seen = np.isfinite(hits.distances)
        units = directions[seen] / np.linalg.norm(directions[seen], axis=1)[:, None]
        field.integrate(place + hits.distances[seen, None] * units, place)
    surface = field.extract(least_weight=0.2)
    check_manifold(surface.faces)
    distances = index.closest_batch(points=surface.vertices).distances
    assert len(distances) > 10000
    assert np.median(distances) < 0.01 and np.percentile(distances, 95) < 0.05


@pytest.mark.parametrize(
    "wrong",
    [
        {"voxel_size": 0.0},
        {"voxel_size": np.nan},
        {"voxel_size": 0.1, "truncation": 0.05},
        {"voxel_size": 0.1, "min_range": 5.0, "max_range": 2.0},
    ],
)
def test_sizes_that_are_none_are_refused(wrong):
    with pytest.raises(ValueError, match="has to be|not ascending"):
        SignedDistanceField(**wrong)
