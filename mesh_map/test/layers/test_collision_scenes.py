"""What stands on floors, hangs over them and leads over them: what the layer of collisions says."""

import numpy as np
import pytest
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.geometry.solids import NO_SOLID, find_solids
from mesh_map.layers.collision import collisions
from mesh_msgs.world import solids
from mesh_msgs.world.solids import box, floor, joined, sheet

EDGE, SIZE = 0.1, 6.0
STEP, HEIGHT = 0.15, 1.0
FLOOR = floor((0, 0), (SIZE, SIZE), EDGE)
X, Y, _ = FLOOR[0].T
HALF = EDGE / 2 + 1e-3  # what is nearer to a vertex of the floor than to others, along an axis


def geometry_of(*parts):
    return MeshGeometry(*joined(*parts))


def lethal_floor(*parts, radius=0.0, step=STEP, height=HEIGHT, ground=FLOOR):
    """(V,) bool: the vertices of the floor that are lethal below these parts."""
    found = collisions(
        geometry_of(ground, *parts), robot_radius=radius, step_height=step, robot_height=height
    )
    return found[: len(ground[0])]


def solid_count(*parts):
    numbers = find_solids(geometry_of(*parts)).numbers
    return len(np.unique(numbers[numbers != NO_SOLID]))


def around(lower, upper, more=0.0):
    """The vertices of the floor in a rectangle, and that far from it."""
    return ((lower[0] - more <= X) & (upper[0] + more >= X) & (lower[1] - more <= Y)) & (
        upper[1] + more >= Y
    )


def from_rectangle(lower, upper):
    """(V,) m from the vertices of the floor to a rectangle."""
    x = np.maximum(np.maximum(lower[0] - X, X - upper[0]), 0)
    y = np.maximum(np.maximum(lower[1] - Y, Y - upper[1]), 0)
    return np.hypot(x, y)


@pytest.mark.parametrize("separate", [False, True], ids=["shared", "24 vertices"])
@pytest.mark.parametrize("bottom", [0.0, -0.05, 0.03, -1.0, 0.6])
@pytest.mark.parametrize("place", [(2.0, 2.0), (2.033, 1.964)], ids=["on vertices", "between"])
@pytest.mark.parametrize("radius", [0.0, 0.25, 0.7])
def test_a_box_that_stands_is_sunk_or_floats(separate, bottom, place, radius):
    """Closed is exactly what is below it, in the radius, or in a cell that it is over."""
    lower, upper = place, (place[0] + 2.0, place[1] + 1.0)
    thing = box((*lower, bottom), (*upper, 2.0), separate)
    assert solid_count(FLOOR, thing) == 1
    lethal, gap = lethal_floor(thing, radius=radius), from_rectangle(lower, upper)
    cells = around(lower, upper, HALF)  # those of some near its corners are not over it
    sure = (np.abs(gap - radius) > 1e-6) & ((gap < 0.04) | ~cells)
    np.testing.assert_array_equal(lethal[sure], ((gap < radius) | cells)[sure])


@pytest.mark.parametrize("height", [0.1, 0.15, 0.16])
@pytest.mark.parametrize("bottom", [0.0, -0.05, 0.03])
def test_what_is_no_higher_than_a_step_is_driven_over(height, bottom):
    """A doorstep, a carpet: be it closed or not."""
    for thing in (box((2, 2, bottom), (3, 3, height)), sheet((1, 2), (4, 2.5), bottom, height)):
        assert lethal_floor(thing).any() == (height > 0.15)


def test_a_box_is_closed_below_and_free_above():
    thing = box((2, 2, 0), (3, 3, 2))
    found = collisions(
        geometry_of(FLOOR, thing), robot_radius=0.3, step_height=STEP, robot_height=HEIGHT
    )
    assert found[len(FLOOR[0]) :].tolist() == [True] * 4 + [False] * 4


@pytest.mark.parametrize("seed", range(5))
def test_boxes_turned_and_tilted(seed):
    """Against what is sampled in the box: below each of these points, the floor is closed."""
    random = np.random.default_rng(seed)
    thing = box((2, 2, -0.1), (4, 3, 1.5))
    center = np.array([3.0, 2.5, 0.5])
    turns = [(axis, random.uniform(-0.6, 0.6)) for axis in range(3)]
    samples = random.uniform((2, 2, -0.1), (4, 3, 1.5), (200000, 3))
    inside = (samples, np.zeros((0, 3), int))
    for axis, angle in turns:
        thing = solids.turned(thing, angle, axis, center)
        inside = solids.turned(inside, angle, axis, center)
    x, y, z = inside[0].T
    body = (z > STEP + 1e-3) & (z < HEIGHT - 1e-3)
    nearest = np.rint(np.stack([x, y], 1)[body] / EDGE).astype(int)
    closed = np.zeros((61, 61), bool)
    closed[nearest[:, 0], nearest[:, 1]] = True
    lethal = lethal_floor(thing).reshape(61, 61)
    assert not (closed & ~lethal).any()
    assert closed.sum() > 200 and (lethal & ~closed).sum() < 0.1 * closed.sum()


@pytest.mark.parametrize(
    "ends", [((3.0, 0.0), (3.0, 6.0)), ((3.03, 0), (3.03, 6)), ((0, 1), (6, 4.7))]
)
@pytest.mark.parametrize("radius", [0.0, 0.25])
def test_a_wall_as_thin_as_a_sheet_leaves_no_gap(ends, radius):
    """Each edge of the floor that it crosses has a lethal end, and nothing far from it has."""
    start, end = np.array(ends, float)
    lethal = lethal_floor(sheet(start, end, 0.0, 2.0), radius=radius)
    along = (end - start) / np.linalg.norm(end - start)
    side = along[0] * (Y - start[1]) - along[1] * (X - start[0])
    edges = geometry_of(FLOOR).topology.edges
    crossed = side[edges[:, 0]] * side[edges[:, 1]] <= 0
    assert crossed.any() and lethal[edges[crossed]].any(axis=1).all()
    assert not lethal[np.abs(side) > max(radius, 0.75 * EDGE)].any()
    assert lethal[np.abs(side) < radius].all()


def test_a_pole_within_a_face_closes_it():
    """It is over no edge and no vertex; the nearest corner of the face is lethal."""
    thing = box((2.06, 2.02, 0.0), (2.07, 2.03, 2.0))
    lethal = lethal_floor(thing)
    assert np.flatnonzero(lethal).tolist() == [int(np.argmin((X - 2.1) ** 2 + (Y - 2) ** 2))]


def building(door=True):
    """Walls 0.2 m thick around a room of 2.6 m by 2.6 m from (1.5, 1.5), with a roof, as one closed
    surface; or without a door, as an outer and an inner one."""
    lower, upper, thick = np.array([1.3, 1.3, 0.0]), np.array([4.3, 4.3, 2.5]), 0.2
    if not door:
        return joined(
            box(lower, upper), solids.flipped(box(lower + [thick, thick, -0.1], upper - thick))
        )
    # A U of walls, profile in plan, up to the roof; the door is the gap in the side towards -y.
    outline = [[2.3, 1.3], [1.3, 1.3], [1.3, 4.3], [4.3, 4.3], [4.3, 1.3], [3.3, 1.3]]
    outline += [[3.3, 1.5], [4.1, 1.5], [4.1, 4.1], [1.5, 4.1], [1.5, 1.5], [2.3, 1.5]]
    quads = [[0, 1, 10, 11], [1, 2, 9, 10], [2, 3, 8, 9], [3, 4, 7, 8], [4, 5, 6, 7]]
    count = len(outline)
    low, high = np.c_[outline, np.zeros(count)], np.c_[outline, np.full(count, 2.5)]
    bottom = np.array([[[a, b, c], [a, c, d]] for a, b, c, d in quads])
    faces = [*bottom, *(bottom[..., ::-1] + count)]
    for k in range(count):
        a, b = k, (k + 1) % count
        faces.append([[a, b + count, b], [a, a + count, b + count]])
    return np.concatenate([low, high]), np.array(faces).reshape(-1, 3)


def test_a_building_with_a_door():
    walls = building()
    assert solid_count(FLOOR, walls) == 1
    lethal = lethal_floor(walls)
    room, doorway = around((1.6, 1.6), (4.0, 4.0)), around((2.4, 1.2), (3.2, 1.6))
    assert not lethal[room | doorway].any()
    everything = around((1.3, 1.3), (4.3, 4.3))
    inner = around((1.51, 1.51), (4.09, 4.09)) | around((2.31, 1.2), (3.29, 1.6))
    np.testing.assert_array_equal(lethal[everything & ~inner], True)
    roof = box((1.3, 1.3, 2.5), (4.3, 4.3, 2.7))
    np.testing.assert_array_equal(lethal_floor(walls, roof), lethal)


@pytest.mark.parametrize("turn", [lambda part: part, solids.flipped], ids=["as it is", "flipped"])
def test_a_closed_building(turn):
    """Of one surface, it is solid; of an outer and an inner one, however turned, its walls are."""
    block = box((1.3, 1.3, 0), (4.3, 4.3, 2.5))
    np.testing.assert_array_equal(lethal_floor(turn(block)), around((1.3, 1.3), (4.3, 4.3)))
    inner = turn(box((1.5, 1.5, 0.05), (4.1, 4.1, 2.3)))
    lethal = lethal_floor(block, inner)
    walls = around((1.3, 1.3), (4.3, 4.3)) & ~around((1.51, 1.51), (4.09, 4.09))
    np.testing.assert_array_equal(lethal, walls)
    table = box((2, 2, 0.06), (3, 3, 1.2))
    with_table = lethal_floor(block, inner, turn(table))
    np.testing.assert_array_equal(with_table, walls | around((2, 2), (3, 3)))


def test_walls_in_walls_are_filled():
    """What overlaps is filled, and a partition with both ends in the walls, too."""
    crossed = box((1, 1, 0), (4, 2, 2)), box((3, 1.5, -0.1), (3.5, 4, 2.2))
    expected = around((1, 1), (4, 2)) | around((3, 1.5), (3.5, 4))
    np.testing.assert_array_equal(lethal_floor(*crossed), expected)
    block = box((1, 1, 0), (5, 5, 2.5)), solids.flipped(box((1.5, 1.5, 0.05), (4.5, 4.5, 2.2)))
    partition = box((1.2, 2, 0.01), (4.8, 3, 2.3))
    walls = around((1, 1), (5, 5)) & ~around((1.51, 1.51), (4.49, 4.49))
    expected = walls | around((1.2, 2), (4.8, 3))
    np.testing.assert_array_equal(lethal_floor(*block, partition), expected)


def test_open_boxes_are_no_solids():
    """A tent without a floor: closed at its sides, free inside."""
    vertices, faces = box((1.3, 1.3, 0), (4.3, 4.3, 2.5))
    tent = vertices, faces[2:]
    assert solid_count(FLOOR, tent) == 0
    lethal = lethal_floor(tent)
    sides = around((1.3, 1.3), (4.3, 4.3)) & ~around((1.31, 1.31), (4.29, 4.29))
    np.testing.assert_array_equal(lethal, sides)


@pytest.mark.parametrize("weld", [False, True], ids=["apart", "corners in common"])
def test_solids_that_share_places_with_the_floor(weld):
    """Corners of the box are vertices of the floor."""
    thing = box((2, 2, 0), (3, 3, 2), separate_sides=not weld)
    both = joined(FLOOR, thing)
    if weld:
        both = solids.welded(both)
        assert len(both[0]) == len(FLOOR[0]) + 4
    assert solid_count(both) == 1
    lethal = collisions(
        MeshGeometry(*both), robot_radius=0.0, step_height=STEP, robot_height=HEIGHT
    )
    x, y, z = both[0].T
    expected = (x > 1.99) & (x < 3.01) & (y > 1.99) & (y < 3.01) & (z < 1)
    np.testing.assert_array_equal(lethal, expected)


@pytest.mark.parametrize("radius", [0.0, 0.25])
def test_a_soup_says_the_same(radius):
    """Each face with vertices of its own, as in STL files."""
    scene = joined(FLOOR, building(), box((4.8, 1, -0.05), (5.5, 5, 1)))
    expected = lethal_floor(building(), box((4.8, 1, -0.05), (5.5, 5, 1)), radius=radius)
    loose = solids.as_soup(scene)
    assert solid_count(loose) == 2
    lethal = collisions(
        MeshGeometry(*loose), robot_radius=radius, step_height=STEP, robot_height=HEIGHT
    )
    of_floor = loose[1][: len(FLOOR[1])]
    np.testing.assert_array_equal(lethal[of_floor], expected[FLOOR[1]])


def odd_boxes():
    """Two boxes, from (2, 2) and from (3, 2), each of 1 m, as exporters leave them; how many solids
    they are is no matter."""
    left, right = box((2, 2, -0.05), (3, 3, 2)), box((3, 2, -0.05), (4, 3, 2))
    corner = box((3, 3, -0.05), (4, 4, 2))
    jitter = np.random.default_rng(1).uniform(-2e-5, 2e-5, (72, 3))
    soup_left, soup_right = solids.as_soup(left), solids.as_soup(right)
    return {
        "faces twice": joined((left[0], np.concatenate([left[1], left[1][3:7]])), right),
        "seen from both sides": joined(
            solids.welded(joined(left, solids.flipped(left))), box((3.1, 2, -0.05), (4, 3, 2))
        ),
        "a face in common": solids.welded(joined(left, right)),
        "all faces twice": solids.welded(joined(left, right, left, right)),
        "all seen from both sides": solids.welded(
            joined(left, right, solids.flipped(left), solids.flipped(right))
        ),
        "one alone twice": solids.welded(joined(left, right, right)),
        "all faces twice, on feet": solids.welded(
            joined(*[left, right] * 2, *[box((x, 2, -0.1), (x + 1, 3, -0.05)) for x in (2, 3)])
        ),
        "an edge in common": joined(solids.welded(joined(left, corner)), right),
        "a soup, rounded": (
            np.concatenate([soup_left[0], soup_right[0]]) + jitter,
            joined(soup_left, soup_right)[1],
        ),
    }


@pytest.mark.parametrize("kind", odd_boxes())
@pytest.mark.parametrize("soup", [False, True], ids=["indexed", "soup"])
def test_solids_as_exporters_leave_them(kind, soup):
    """Between their sides they are filled, however these are joined."""
    thing = odd_boxes()[kind]
    lethal = lethal_floor(solids.as_soup(thing) if soup else thing)
    inside = around((2.2, 2.2), (2.8, 2.8)) | around((3.2, 2.2), (3.8, 2.8))
    assert lethal[inside].all()
    assert not lethal[~around((2, 2), (4, 4), HALF)].any()
    if kind == "an edge in common":
        assert lethal[around((3.2, 3.2), (3.8, 3.8))].all()
        assert not lethal[around((2.2, 3.2), (2.8, 3.8))].any()
    else:
        assert not lethal[~around((2, 2), (4, 3), HALF)].any()


@pytest.mark.parametrize("offset", [0.0, 2e5])
def test_rims_keep_their_places(offset):
    """A vertex far away, or coarse coordinates, do not make one of the corners of a border; a row
    of corners that are near to each other stays as long as it is."""
    ground = floor((0, 0), (2, 2), 0.05)
    row = np.stack([np.arange(100) * 9e-5, np.full(100, 3.0), np.zeros(100)], 1)
    strip = np.concatenate([row, row + [0, 1, 0]])
    strip = strip, np.array([[i, i + 1, i + 100] for i in range(99)])
    far = np.array([[1e6, 0.0, 0.0]] * 3) * [[1], [1.1], [1.2]], np.array([[0, 1, 2]])
    vertices, faces = joined(ground, strip, *([] if offset else [far]))
    geometry = MeshGeometry(np.float32(vertices + [offset, 0, 0]), faces)
    joins = find_solids(geometry).joined
    moved = np.linalg.norm(geometry.vertices[joins] - geometry.vertices, axis=1)
    assert moved[: len(ground[0]) + 200].max() <= 1e-3


def test_a_sheet_seen_from_both_sides_is_no_solid():
    wall = sheet((1, 2), (4, 2), 0.0, 2.0)
    both = solids.welded(joined(wall, solids.flipped(wall)))
    np.testing.assert_array_equal(lethal_floor(both), lethal_floor(wall))


@pytest.mark.parametrize("radius", [0.0, 0.25])
def test_a_table(radius):
    """A top on four legs: closed below for a robot that is higher, but for the legs open else."""
    top = box((2, 2, 0.7), (4, 3.5, 0.74))
    corners = [(x, y) for x in (2.0, 3.9) for y in (2.0, 3.4)]
    legs = [box((x, y, 0), (x + 0.1, y + 0.1, 0.7)) for x, y in corners]
    low = lethal_floor(top, *legs, radius=radius, height=0.6)
    feet = np.min([from_rectangle((x, y), (x + 0.1, y + 0.1)) for x, y in corners], axis=0)
    sure = np.abs(feet - radius) > 1e-6
    np.testing.assert_array_equal(low[sure], (feet <= radius)[sure])
    high = lethal_floor(top, *legs, radius=radius, height=0.8)
    gap = from_rectangle((2, 2), (4, 3.5))
    sure = np.abs(gap - radius) > 1e-6
    np.testing.assert_array_equal(high[sure], (gap <= radius)[sure])
    assert not lethal_floor(top, *legs[:0], height=0.7).any()  # exactly as high


@pytest.mark.parametrize("radius", [0.0, 0.25])
def test_a_bridge(radius):
    """A deck with two meters below it: free above and below, its piers closed."""
    deck = floor((0.95, 2), (5.05, 3), EDGE, level=2.3)
    slab = box((0.95, 2, 2.0), (5.05, 3, 2.3))
    piers = [box((1, 2, 0), (1.3, 3, 2.05)), box((4.7, 2, 0), (5, 3, 2.05))]
    found = collisions(
        geometry_of(FLOOR, deck, slab, *piers),
        robot_radius=radius,
        step_height=STEP,
        robot_height=1.8,
    )
    below, above = np.split(found[: len(FLOOR[0]) + len(deck[0])], [len(FLOOR[0])])
    assert not above.any()
    gap = np.minimum(from_rectangle((1, 2), (1.3, 3)), from_rectangle((4.7, 2), (5, 3)))
    sure = np.abs(gap - radius) > 1e-6
    np.testing.assert_array_equal(below[sure], (gap <= radius)[sure])


@pytest.mark.parametrize("radius", [0.0, 0.25, 0.5])
@pytest.mark.parametrize("rise", [0.17, 0.18, 0.2])
def test_stairs(radius, rise):
    """Those of step_height are climbed, also where the body is over several of them; higher ones
    are closed at the foot of each."""
    lower = floor((0, 0), (2, 2), EDGE)
    steps = solids.stairs((2, 0, 0), 2.0, 0.28, rise, 8, EDGE)
    landing = floor((2 + 8 * 0.28, 0), (6, 2), EDGE, level=8 * rise)
    vertices, faces = solids.welded(joined(lower, steps, landing))
    lethal = collisions(
        MeshGeometry(vertices, faces), robot_radius=radius, step_height=0.18, robot_height=1.2
    )
    if rise <= 0.18:
        assert not lethal.any()
    else:
        for step in range(8):
            away = np.abs(vertices - [2 + 0.28 * step, 0, rise * step])
            foot = away[:, [0, 2]].max(axis=1) < 1e-3
            assert foot.sum() > 10 and lethal[foot].all()
        before = vertices[:, 0] < 2 - max(radius, HALF) - 1e-3
        assert not lethal[before].any()


@pytest.mark.parametrize("radius", [0.0, 0.25, 0.6])
@pytest.mark.parametrize("degrees", [5, 20, 30, 40])
def test_ramps_are_ground(radius, degrees):
    """Whatever the floor rises within the radius; a wall and a ceiling over it are obstacles."""
    slope = np.tan(np.radians(degrees))
    x = np.maximum(FLOOR[0][:, 0] - 2, 0)
    ramp = np.column_stack([FLOOR[0][:, :2], slope * np.minimum(x, 2)]), FLOOR[1]
    assert not lethal_floor(radius=radius, ground=ramp).any()
    rises = slope * 1.5
    wall = sheet((3.5, 0), (3.5, 6), rises - 0.05, rises + 2.5)
    lethal = lethal_floor(wall, radius=radius, ground=ramp)
    np.testing.assert_array_equal(lethal, np.abs(X - 3.5) <= max(radius, 1e-3) + 1e-6)
    ceiling = floor((3, 1), (4, 2), 0.5, level=slope * 2 + 0.9)
    lethal = lethal_floor(ceiling, radius=radius, ground=ramp)
    # where the surface is less than a meter below it, at the end of the ramp, or is so in a cell
    top = slope * (np.minimum(x, 2) - 2) + 0.1
    gap = from_rectangle((3, 1), (4, 2))
    assert lethal[(top > 1e-3) & (gap <= radius)].all()
    reached = (top > -1e-3) & (gap <= radius + 1e-6)
    reached |= (top > -1e-3 - slope * HALF) & (gap < HALF)
    assert not lethal[~reached].any()


def test_curbs_of_one_surface_are_obstacles_of_the_body():
    """A curb that is too high closes the floor within the radius, and one of a step does not."""
    for rise in (0.15, 0.2):
        lower, upper = floor((0, 0), (3, 6), EDGE), floor((3, 0), (6, 6), EDGE, level=rise)
        face = sheet((3, 0), (3, 6), 0.0, rise)
        subdivided = solids.stairs((3, 0, 0), 6.0, 0.1, rise, 1, EDGE)
        for curb in (face, subdivided):
            vertices, faces = solids.welded(joined(lower, curb, upper))
            lethal = collisions(
                MeshGeometry(vertices, faces), robot_radius=0.25, step_height=STEP, robot_height=1.0
            )
            x, _, z = vertices.T
            expected = (rise > STEP) & (z < 1e-6) & (x >= 3 - 0.25 - 1e-6) & (x < 3 + 1e-6)
            sure = (x <= 3) | (z > 0.1)
            np.testing.assert_array_equal(lethal[sure], expected[sure])


def test_coarse_floors():
    """One face more than the wall is long: its nearest corner is lethal, so that it is closed."""
    ground = floor((0, 0), (6, 6), 6.0)
    lethal = lethal_floor(sheet((1, 0.5), (2, 0.5), 0, 2), ground=ground)
    assert lethal.tolist() == [True, False, False, False]


@pytest.mark.parametrize("offset", [0.0, 1e3, 1e5])
def test_far_from_the_origin(offset):
    """Where float32 resolves 8 mm, a box on the floor is still what it is."""
    thing = box((2, 2, 0), (4, 3, 2))
    scene = joined(FLOOR, thing)
    moved = np.float32(scene[0] + [offset, -offset, 0])
    lethal = collisions(
        MeshGeometry(moved, scene[1]), robot_radius=0.0, step_height=STEP, robot_height=HEIGHT
    )[: len(FLOOR[0])]
    assert lethal[around((2, 2), (4, 3))].all()
    assert not lethal[~around((2, 2), (4, 3), HALF + 0.05)].any()
