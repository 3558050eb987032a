"""Pictures of plans."""

import io

import numpy as np
import pytest
from mesh_msgs import zoo
from mesh_msgs_hdf5.rendering.render_paint import PLAIN
from mesh_msgs_hdf5.rendering.render_camera import VIEWS, look_at
from mesh_msgs_hdf5.rendering.render_scale import RAINBOW, RED_GREEN, scale_colors

from mesh_navigation.base.pose import Pose
from mesh_navigation.commands import picture
from mesh_navigation.commands.picture import CLOSED, PotentialPaint, plan_picture
from mesh_navigation.plugins.planner import PlanResult
from navigation_test_maps import MapWithCosts

GRID = zoo.grid()
X, Y = GRID.vertices[:, 0], GRID.vertices[:, 1]
PIXELS = 1000
CENTER = np.full((1, 3), 1 / 3)


def paint(potential, passable=True, vertices=GRID.vertices, faces=GRID.faces):
    potential = np.float32(potential)
    return PotentialPaint(
        vertices, faces, potential, np.broadcast_to(passable, len(vertices)), PIXELS
    )


def color_at(painted, x, y):
    """The color of the grid at a place."""
    for face, corners in enumerate(GRID.faces):
        ones = np.column_stack([GRID.vertices[corners, :2].astype(float), np.ones(3)])
        weights = np.linalg.solve(ones.T, [x, y, 1])
        if weights.min() >= 0:
            return painted.colors(np.array([face]), weights[None])[0]
    raise AssertionError((x, y))


def test_colors_and_lines_of_a_plane():
    """A potential of x: lines every meter, about a pixel wide, and the colors of RViz between."""
    painted = paint(X)
    assert painted.legend.limits == (0, 10) and "every 1 m" in painted.legend.title
    pixel = 10 / PIXELS
    for x in (0.5, 1.37, 9.9):
        expected = scale_colors(RAINBOW, np.array([x / 10]))[0]
        np.testing.assert_allclose(color_at(painted, x, 4.3), expected, atol=1e-6)
    for x in (1.0, 3.0 + 0.4 * pixel, 7.0 - 0.4 * pixel):
        beside = scale_colors(RAINBOW, np.array([x / 10]))[0]
        np.testing.assert_allclose(color_at(painted, x, 4.3), 0.55 * beside, atol=1e-6)
    for x in (1 + 2 * pixel, 3 - 2 * pixel):
        expected = scale_colors(RAINBOW, np.array([x / 10]))[0]
        np.testing.assert_allclose(color_at(painted, x, 4.3), expected, atol=1e-6)


@pytest.mark.parametrize("slope, step", [(0.1, 0.1), (3, 2), (7, 5), (1e-6, 1e-6)])
def test_lines_are_equally_wide_whatever_the_slope(slope, step):
    painted = paint(slope * X)
    at, pixel = step / slope, 10 / PIXELS
    if at > 10:
        return
    on = color_at(painted, at + 0.5 * pixel, 4.3).sum()
    off = color_at(painted, at + 1.5 * pixel, 4.3).sum()
    assert on < 0.7 * off


def test_what_is_not_reached_or_closed():
    potential = np.where(X > 6, np.inf, X)
    painted = paint(potential, Y < 8)
    np.testing.assert_array_equal(color_at(painted, 8.2, 3.1), PLAIN)
    np.testing.assert_array_equal(color_at(painted, 2.2, 9.1), CLOSED)
    np.testing.assert_array_equal(color_at(painted, 8.2, 9.1), CLOSED)
    assert color_at(painted, 2.25, 3.1).max() > 0.9
    closed, reached = int((Y >= 8).sum()), int((X <= 6).sum())
    unknown = int(((X > 6) & (Y < 8)).sum())
    assert [text for text, _ in painted.legend.entries] == [
        f"closed ({closed})",
        f"not reached ({unknown})",
    ]
    assert painted.legend.limits == (0, 6) and reached


def test_no_potential_at_all():
    painted = paint(np.full(len(X), np.inf))
    assert (painted.legend.limits, painted.legend.title) == (None, "no potential")
    np.testing.assert_array_equal(color_at(painted, 2.2, 9.1), PLAIN)


@pytest.mark.parametrize("mesh", [zoo.zero_area_face(), zoo.sliver(), zoo.moebius_strip()])
def test_odd_faces(mesh):
    potential = np.linspace(0, 3, len(mesh.vertices))
    painted = paint(potential, True, mesh.vertices, mesh.faces)
    with np.errstate(all="raise"):
        found = painted.colors(np.arange(len(mesh.faces)), np.repeat(CENTER, len(mesh.faces), 0))
    assert found.shape == (len(mesh.faces), 3) and found.min() >= 0 and found.max() <= 1


def drawn(mesh_map, result, ends, **options):
    image = pytest.importorskip("PIL.Image")
    png = plan_picture(mesh_map, result, ends, 1.0, size=(600, 450), **options)
    with image.open(io.BytesIO(png)) as opened:
        return np.asarray(opened.convert("RGB")).astype(int)


def result_along(points, potential=None):
    poses = np.zeros((len(points), 7))
    poses[:, :3], poses[:, 6] = points, 1
    return PlanResult(0, "", poses, potential=None if potential is None else np.float32(potential))


def dark(shown):
    """Pixels within the axes that are black."""
    inner = shown[60:380, 80:480]
    return int((inner.max(axis=2) < 40).sum())


def test_the_path_is_on_the_picture_and_dotted_where_it_is_hidden():
    below = np.linspace([1, 5, 0], [9, 5, 0], 60)
    ends = [Pose.at(below[0]), Pose.at(below[-1])]
    open_sky = MapWithCosts(GRID)
    potential = np.hypot(X - 9, Y - 5)
    parts = []
    path = drawn(open_sky, result_along(below, potential), ends, progress=parts.append)
    none = drawn(open_sky, PlanResult(54, "", potential=np.float32(potential)), ends)
    assert parts[-1] == pytest.approx(1.0) and path.shape == (450, 600, 3)
    assert dark(path) > dark(none) + 300
    roof = zoo.two_storeys(cells=10, size=10.0)
    both = np.linspace(0, 1, len(roof.vertices))  # both storeys were reached
    hidden = drawn(MapWithCosts(roof), result_along(below, both), ends, view=VIEWS["top"])
    bare = drawn(MapWithCosts(roof), PlanResult(54, "", potential=both), ends, view=VIEWS["top"])
    assert 30 < dark(hidden) - dark(bare) < 0.8 * (dark(path) - dark(none))


def view_of(monkeypatch, *arguments, **options):
    """The view of a picture, and the heights of what it shows."""
    found = []

    def look(mesh, _paint, view, *_others):
        found.extend([view, np.unique(mesh.vertices[:, 2].round(3)).tolist()])
        return b""

    monkeypatch.setattr(picture, "picture_png", look)
    plan_picture(*arguments, 1.0, **options)
    return found


def test_storeys_are_seen_where_they_were_searched(monkeypatch):
    roof = zoo.two_storeys(cells=10, size=10.0)
    height = roof.vertices[:, 2]
    path = result_along(np.linspace([1, 5, 0], [9, 5, 0], 60), np.where(height < 1, 1.0, np.inf))
    ends = [Pose.at([1, 5, 0]), Pose.at([9, 5, 0])]
    view, heights = view_of(monkeypatch, MapWithCosts(roof), path, ends)
    assert view == VIEWS["top"] and max(heights) < 2  # without the storey that hides the path
    both = result_along(path.poses[:, :3], np.ones(len(height)))
    view, heights = view_of(monkeypatch, MapWithCosts(roof), both, ends)
    assert view == VIEWS["iso"] and max(heights) == pytest.approx(height.max())
    view, _ = view_of(monkeypatch, MapWithCosts(roof), both, ends, view=VIEWS["side"])
    assert view == VIEWS["side"]


class Lines:
    """Axes that keep the black lines that are drawn."""

    def __init__(self):
        self.black = []

    def plot(self, x, y, *_, color="", linestyle="", **__):
        if color == "black":
            self.black.append((np.column_stack([x, y]), linestyle))

    def annotate(self, *_, **__):
        pass


def test_the_path_follows_the_view(monkeypatch):
    """It is drawn where the camera sees it, and dotted where the view, not the sky, is hidden."""
    roof = zoo.two_storeys(cells=10, size=10.0)
    points = np.linspace([1, 5, 0], [9, 5, 0], 60)
    result = result_along(points, np.ones(len(roof.vertices)))
    ends = [Pose.at(points[0]), Pose.at(points[-1])]
    for name, style in (("top", (0, (1, 1.5))), ("front", "solid")):
        lines, camera = Lines(), look_at(roof.vertices, VIEWS[name], 100, 100)

        def draw(*arguments, lines=lines, camera=camera):
            arguments[6](lines, camera)
            return b""

        monkeypatch.setattr(picture, "picture_png", draw)
        plan_picture(MapWithCosts(roof), result, ends, 1.0, view=VIEWS[name])
        ((drawn_points, linestyle),) = lines.black
        assert linestyle == style
        np.testing.assert_allclose(drawn_points, points @ camera.axes[:2].T, atol=1e-9)


def test_colors_of_another_scale():
    painted = PotentialPaint(GRID.vertices, GRID.faces, X, np.full(len(X), True), PIXELS, RED_GREEN)
    expected = scale_colors(RED_GREEN, np.array([0.137]))[0]
    np.testing.assert_allclose(color_at(painted, 1.37, 4.3), expected, atol=1e-6)
    assert painted.legend.stops is RED_GREEN


def test_the_part_of_the_map_that_was_searched():
    """A map of 10 m, a search in 3 m of it: what is far from that is not in the picture."""
    potential = np.where((X < 3.1) & (Y < 3.1), X + Y, np.inf)
    ends = [Pose.at([0.5, 0.5, 0]), Pose.at([2.5, 2.5, 0])]
    inside = drawn(MapWithCosts(GRID), result_along(np.zeros((0, 3)), potential), ends)
    all_of_it = drawn(MapWithCosts(GRID), result_along(np.zeros((0, 3)), X + Y), ends)

    def gray_share(shown):
        spread = shown.max(axis=2) - shown.min(axis=2)
        return np.mean(spread[60:380, 80:480] < 10)

    assert gray_share(inside) < 0.75 and inside.shape == all_of_it.shape


def test_ends_that_are_not_finite():
    ends = [Pose.at([np.nan, 0.5, 0]), Pose.at([2.5, np.inf, 0])]
    assert drawn(MapWithCosts(GRID), PlanResult(52, ""), ends).shape == (450, 600, 3)
