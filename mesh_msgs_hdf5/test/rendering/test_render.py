"""Pictures of meshes, against a slow and simple way to make them."""
import io

import matplotlib.image
import numpy as np
import pytest
from matplotlib.text import Text
from mesh_msgs import zoo

from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.mesh import Label, Materials, Mesh
from mesh_msgs_hdf5.rendering.render import choose_paint, paint_mesh
from mesh_msgs_hdf5.rendering.render_camera import (
    VIEWS,
    axis_names,
    look_at,
    usual_view,
    view_axes,
)
from mesh_msgs_hdf5.rendering.render_figure import picture_png
from mesh_msgs_hdf5.rendering.render_paint import PLAIN
from mesh_msgs_hdf5.rendering.render_raster import NO_FACE, visible_faces
from mesh_msgs_hdf5.rendering.render_scale import LETHAL, RAINBOW, UNKNOWN, value_colors

WALL = Mesh(
    np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=np.float32),
    np.array([[0, 1, 2], [0, 2, 3]], dtype=np.uint32),
)


def slow_faces(screen, faces, width, height):
    """(nearest face, depth of the two nearest) at each pixel's center, one face at a time."""
    x, y = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    depths = np.full((len(faces), height, width), np.inf)
    for i, face in enumerate(faces):
        a, b, c = screen[face]
        matrix = np.array([b[:2] - a[:2], c[:2] - a[:2]]).T
        if abs(np.linalg.det(matrix)) < 1e-12:
            continue
        s, t = np.einsum("ij,jhw->ihw", np.linalg.inv(matrix), np.stack([x - a[0], y - a[1]]))
        inside = (s >= 0) & (t >= 0) & (s + t <= 1)
        depth = a[2] + s * (b[2] - a[2]) + t * (c[2] - a[2])
        depths[i] = np.where(inside, depth, np.inf)
    return depths


def test_the_nearest_face_is_shown_at_each_pixel():
    rng = np.random.default_rng(3)
    for size in (3, 40, 400):  # smaller than a pixel, some pixels, larger than the picture
        screen = rng.uniform(-20, 84, (60, 3))
        screen[20:] = screen[:20].repeat(2, axis=0) + rng.normal(0, size / 3, (40, 3))
        faces = np.column_stack([np.arange(20), np.arange(20, 60, 2), np.arange(21, 60, 2)])
        depths = slow_faces(screen, faces, 64, 48)
        shown = visible_faces(screen, faces.astype(np.uint32), 64, 48)
        expected = np.where(np.isfinite(depths).any(axis=0), depths.argmin(axis=0), NO_FACE)
        assert shown.dtype == np.int32 and np.array_equal(shown, expected), size
        assert (shown >= 0).any()


@pytest.mark.parametrize(
    "mesh", [m for m in zoo.all_meshes() if len(m.faces)], ids=lambda m: m.name
)
@pytest.mark.parametrize("view", [(-81.3, 77.1), (-50.3, 37.7), (12.9, -61.3)])
def test_a_closed_surface_has_no_gap_and_nothing_is_drawn_beside_it(mesh, view):
    vertices = mesh.vertices.astype(np.float64)
    camera = look_at(mesh.vertices, view, 60, 50)
    screen = camera.screen(vertices)
    depths = slow_faces(screen, mesh.faces, 60, 50)
    covered = np.isfinite(depths).any(axis=0)
    shown = visible_faces(screen, mesh.faces, 60, 50)
    assert np.array_equal(shown != NO_FACE, covered)
    inner = np.flatnonzero(covered)
    got = depths.reshape(len(mesh.faces), -1)[shown.ravel()[inner], inner]
    least = depths.reshape(len(mesh.faces), -1)[:, inner].min(axis=0)
    assert np.allclose(got, least, rtol=1e-6, atol=1e-9)  # faces at one place: any of them


def test_the_order_of_faces_and_blocks_does_not_matter(monkeypatch):
    mesh = zoo.outdoor_world(2000)
    camera = look_at(mesh.vertices, VIEWS["iso"], 120, 90)
    screen = camera.screen(mesh.vertices)
    shown = visible_faces(screen, mesh.faces, 120, 90)
    order = np.random.default_rng(0).permutation(len(mesh.faces))
    other = visible_faces(screen, mesh.faces[order], 120, 90)
    assert np.array_equal(np.where(other >= 0, order[other], NO_FACE), shown)
    for name, size in (("_FACES", 7), ("_ROWS", 5), ("_PIXELS", 3)):
        monkeypatch.setattr("mesh_msgs_hdf5.rendering.render_raster." + name, size)
    few = mesh.faces[:300]
    monkeypatched = visible_faces(screen, few, 120, 90)
    monkeypatch.undo()
    assert np.array_equal(monkeypatched, visible_faces(screen, few, 120, 90))


def test_views():
    assert np.array_equal(view_axes(*VIEWS["top"]), np.eye(3))
    front = view_axes(*VIEWS["front"])
    assert front.tolist() == [[1, 0, 0], [0, 0, 1], [0, -1, 0]]
    for view in [*VIEWS.values(), (33.0, -20.0)]:
        axes = view_axes(*view)
        assert np.allclose(axes @ axes.T, np.eye(3)) and np.isclose(np.linalg.det(axes), 1)
    camera = look_at(WALL.vertices, VIEWS["top"], 100, 200)
    left, right, bottom, top = camera.extent
    assert np.isclose(right - left, 1 / 0.94) and np.isclose(top - bottom, 2 / 0.94)
    assert np.isclose((left + right) / 2, 0.5) and axis_names(camera.axes) == ("x", "y")
    assert axis_names(look_at(WALL.vertices, VIEWS["iso"], 100, 200).axes) == ("", "")


def test_the_usual_view_shows_storeys():
    """From above where nothing level is hidden; what is steep, or small, does not count."""
    for made in (zoo.grid(), zoo.two_components(), zoo.sphere()):
        assert usual_view(made.vertices, made.faces) == VIEWS["top"], made.name
    house = zoo.two_storeys()
    assert usual_view(house.vertices, house.faces) == VIEWS["iso"]
    turned = house.vertices[:, [2, 1, 0]]  # on its side: walls beside each other
    assert usual_view(turned, house.faces) == VIEWS["top"]


def colors_of(mesh, *arguments, view="top", **keywords):
    """(height, width, 3) from 0 to 1 of a picture of the wall, which looks to the light."""
    paint = choose_paint("x.h5", mesh, *arguments, **keywords)
    picture = paint_mesh(mesh, look_at(mesh.vertices, VIEWS[view], 50, 50), paint)
    assert picture.shape == (50, 50, 4) and picture[25, 25, 3] == 255 and picture[0, 0, 3] == 0
    return picture[..., :3] / 255.0


def hue(color):
    """The color without its brightness."""
    return np.asarray(color) / max(color)


def test_costs_have_the_colors_of_rviz_and_lethal_and_unknown_their_own():
    magenta, yellow, red = RAINBOW[0], RAINBOW[4], RAINBOW[5]
    values = np.array([-1, 0, 0.8, 1, 7, np.inf, np.nan, -np.inf])
    expected = [magenta, magenta, yellow, red, red, LETHAL, UNKNOWN, magenta]
    assert np.allclose(value_colors(RAINBOW, (0.0, 1.0), values), expected)
    assert np.allclose(value_colors(RAINBOW, (3.0, 3.0), np.array([3.0])), [magenta])
    mesh = Mesh(WALL.vertices, WALL.faces)
    mesh.vertex_costs["slope"] = np.array([0, 0, 1, 1], dtype=np.float32)  # grows with y
    colors = colors_of(mesh, "layer", "slope")
    for row, part in ((46, 0.04), (25, 0.5), (15, 0.72)):
        expected = value_colors(RAINBOW, (0, 1), np.array([(49.5 - row - 1.5) / 47]))[0]
        assert np.allclose(hue(colors[row, 25]), hue(expected), atol=0.05), (row, part)
    mesh.vertex_costs["slope"] = np.array([np.inf, np.nan, 1, np.nan], dtype=np.float32)
    colors = colors_of(mesh, "layer", "slope")
    assert np.allclose(hue(colors[46, 3]), hue(LETHAL), atol=0.02)
    assert np.allclose(hue(colors[46, 46]), hue(UNKNOWN), atol=0.02)
    limited = colors_of(mesh, "layer", "slope", limits=(1.0, 2.0))
    assert np.allclose(hue(limited[4, 45]), magenta)


def test_what_a_layer_calls_lethal_is_painted_so():
    mesh = Mesh(WALL.vertices, WALL.faces)
    mesh.vertex_costs["slope"] = np.array([0.1, 0.1, 0.5, 0.5], dtype=np.float32)  # grows with y
    rule = {"unit": "rad", "comparison": "above", "threshold": 0.3}
    mesh.layer_parameters["slope"] = {"layer_info": rule}
    colors = colors_of(mesh, "layer", "slope")
    assert np.allclose(hue(colors[4, 25]), hue(LETHAL), atol=0.02)
    assert not np.allclose(hue(colors[46, 25]), hue(LETHAL), atol=0.02)
    legend = choose_paint("x.h5", mesh, "layer", "slope").legend
    assert legend.title == "slope [rad]"
    assert legend.entries == (("lethal, above 0.3 rad (2)", LETHAL),)
    assert legend.limits == (np.float32(0.1), np.float32(0.1)), "of what is not lethal"
    plain = colors_of(mesh, "layer", "slope", mark_lethal=False)
    assert np.allclose(hue(plain[4, 25]), hue(RAINBOW[5]), atol=0.4)
    mesh.layer_parameters["slope"] = {"layer_info": {"comparison": "other", "lethal": 3}}
    legend = choose_paint("x.h5", mesh, "layer", "slope").legend
    assert legend.entries[0][0] == "lethal, not by their values alone (3)"


def test_faces_labels_colors_and_textures():
    mesh = Mesh(WALL.vertices, WALL.faces)
    mesh.face_attributes["area"] = np.array([0, 5], dtype=np.int64)
    colors = colors_of(mesh, "layer", "area")  # there is no layer of that name
    assert np.allclose(hue(colors[40, 40]), RAINBOW[0]) and np.allclose(
        hue(colors[8, 8]), RAINBOW[5]
    )
    mesh.labels["tree_1"] = Label(np.array([1], dtype=np.uint32), (0, 0, 255))
    colors = colors_of(mesh, "labels")
    assert np.allclose(hue(colors[8, 8]), (0, 0, 1)) and np.allclose(
        hue(colors[40, 40]), hue(PLAIN)
    )
    mesh.vertex_colors = np.array([[255, 0, 0]] * 4, dtype=np.uint8)
    assert np.allclose(hue(colors_of(mesh, "colors")[8, 8]), (1, 0, 0))
    mesh.materials = Materials(
        np.array([[0, 0, 255], [0, 0, 0]], dtype=np.uint8),
        np.array([-1, 7], dtype=np.int32),
        np.array([0, 1], dtype=np.uint32),
    )
    mesh.textures[7] = np.zeros((2, 2, 3), dtype=np.uint8)
    mesh.textures[7][0] = 0, 255, 0  # the top
    mesh.textures[7][1] = 255, 255, 0
    mesh.texture_coordinates = WALL.vertices[:, :2].copy()
    colors = colors_of(mesh, "textures")
    assert np.allclose(hue(colors[40, 45]), (0, 0, 1))
    assert np.allclose(hue(colors[4, 20]), (0, 1, 0)) and np.allclose(hue(colors[40, 4]), (1, 1, 0))


def test_slopes_are_shaded_and_both_sides_alike():
    mesh = zoo.sphere(4)
    mesh = Mesh(mesh.vertices, mesh.faces, vertex_colors=np.full_like(mesh.vertices, 255, "u1"))
    colors = colors_of(mesh, "colors")
    assert colors[14, 16].mean() > colors[25, 25].mean() > colors[38, 36].mean() > 0.4
    mesh.faces = mesh.faces[:, ::-1].copy()
    assert np.array_equal(colors_of(mesh, "colors"), colors)


@pytest.mark.parametrize(
    "what,name", [("layer", "x"), ("face", "x"), ("labels", None), ("textures", None)]
)
def test_what_the_mesh_does_not_have_is_refused(what, name):
    with pytest.raises(MapFileError) as error:
        choose_paint("x.h5", WALL, what, name)
    assert error.value.code == "layer" and error.value.hint


@pytest.mark.parametrize("view", sorted(VIEWS))
def test_the_png_has_the_size_and_the_mesh_in_it(view, recwarn):
    world = zoo.outdoor_world(1000)
    mesh = Mesh(world.vertices, world.faces, crs="EPSG:25832", origin=(4e5, 5e6, 0))
    mesh.vertex_costs["cost $^$ 樹"] = np.where(world.vertices[:, 0] > 0, np.inf, 1).astype("f4")
    for what, name in (("height", None), ("layer", "cost $^$ 樹")):
        paint = choose_paint("x", mesh, what, name)
        parts = []
        png = picture_png(mesh, paint, VIEWS[view], (640, 480), "a $title_{", parts.append)
        picture = matplotlib.image.imread(io.BytesIO(png), "png")
        assert picture.shape[:2] == (480, 640) and parts[-1] == 1 and parts == sorted(parts)
        assert (picture[..., :3].min(axis=2) < 0.9).mean() > 0.01
    assert not [str(warning.message) for warning in recwarn.list]


def test_many_labels_and_tiny_pictures():
    mesh = Mesh(WALL.vertices, WALL.faces)
    mesh.labels = {"tree_%d" % i: Label(np.zeros(0, dtype=np.uint32)) for i in range(100)}
    paint = choose_paint("x", mesh, "labels")
    assert len(paint.legend.entries) == 101 and "labels: 100, classes: 1" == paint.legend.title
    for size in ((200, 200), (1200, 300)):
        png = picture_png(mesh, paint, VIEWS["top"], size, "x" * 300)
        assert matplotlib.image.imread(io.BytesIO(png), "png").shape[1::-1] == size


@pytest.mark.parametrize("size", [(300, 200), (400, 300), (1200, 900)])
@pytest.mark.parametrize("what", ["labels", "layer"])
def test_nothing_is_cut_off_at_the_edges_of_a_picture(size, what):
    name = "slope of the ground as the long wheelbase of a large robot feels it when driving"
    vertices = np.array([[0, 0, 0], [4, 0, 0], [0, 2, 0]], np.float32)
    mesh = Mesh(vertices, np.array([[0, 1, 2]], np.uint32), crs="EPSG:25832")
    mesh.vertex_costs[name] = np.array([0, 1, 2], np.float32)
    mesh.labels = {"class_%d" % i: Label(np.array([0], np.uint32)) for i in range(40)}
    mesh.origin = (431235.0, 5791235.0, 63.0)
    paint = choose_paint("a", mesh, what, name)
    png = picture_png(mesh, paint, VIEWS["top"], size, name)
    pixels = matplotlib.image.imread(io.BytesIO(png))[:, :, :3]
    assert pixels.shape == (size[1], size[0], 3)
    edges = [pixels[:2], pixels[-2:], pixels[:, :2], pixels[:, -2:]]
    assert [bool((edge == 1).all()) for edge in edges] == [True] * 4


@pytest.mark.parametrize("size", [(640, 480), (1200, 900)])
@pytest.mark.parametrize("what", ["layer", "labels"])
def test_every_text_has_room_in_the_figure(size, what, monkeypatch):
    costs = np.float32([0.1, 0.9, 0.2, np.nan, np.inf, 0.3])
    vertices = np.float32([[0, 0, 0], [4, 0, 0], [0, 2, 0], [4, 2, 0], [0, 4, 0], [4, 4, 0]])
    faces = np.uint32([[0, 1, 2], [1, 3, 2], [2, 3, 4], [3, 5, 4]])
    mesh = Mesh(vertices, faces)
    mesh.vertex_costs["slope"] = costs
    rule = {"unit": "rad", "comparison": "above", "threshold": 0.7}
    mesh.layer_parameters["slope"] = {"layer_info": rule}
    mesh.labels = {"MMMMMMMMMMMMMMMMMMMMMMMMMMMMMMMM": Label(np.uint32([0]))}
    paint = choose_paint("x", mesh, what, "slope" if what == "layer" else None)
    boxes, draw = {}, Text.draw

    def drawn(text, renderer, *arguments, **keywords):
        draw(text, renderer, *arguments, **keywords)
        if text.get_text() and text.get_visible():
            boxes[text.get_text()] = text.get_window_extent(renderer)

    monkeypatch.setattr(Text, "draw", drawn)
    picture_png(mesh, paint, VIEWS["top"], size, "title")
    assert {"title", "x [m]"} < set(boxes) and len(boxes) > 10
    assert paint.legend.entries and {"lethal, above 0.7 rad (2)", "M" * 25 + "..."} & set(boxes)
    for text, box in boxes.items():
        assert 0 <= box.x0 and box.x1 <= size[0] and 0 <= box.y0 and box.y1 <= size[1], text
