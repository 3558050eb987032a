"""Where what closes a hole would lie on its rim, the rim is replaced; openings keep theirs."""

from dataclasses import replace

import numpy as np
from mesh_msgs import zoo
from mesh_msgs_hdf5.model.mesh import Mesh

from mesh_map.geometry.border_loops import border_loops
from mesh_map.reconstruction.drivable_surface import drivable
from mesh_map.reconstruction.options import SurfaceOptions
from mesh_map.reconstruction.surface_closing import closed_surface

OPTIONS = SurfaceOptions(min_component=20)


def with_hole(width, turned=True, below=False):
    """Level ground, edges of 0.1 m, with a square hole; two vertices of its rim lie back on it."""
    ground = zoo.grid(60, 6.0)
    vertices, faces = ground.vertices.copy(), ground.faces
    middles = vertices[faces].mean(axis=1)[:, :2]
    inside = (np.abs(middles - 3.0) < width / 2).all(axis=1)
    faces = faces[~inside]
    rim = border_loops(faces, len(vertices))
    loop = min(np.split(rim.vertices, rim.offsets[1:-1]), key=len)
    if turned:
        for vertex in loop[[2, 9]]:
            vertices[vertex] += 0.25 * np.sign(np.round(vertices[vertex] - [3, 3, 0], 3))
            vertices[vertex, 2] = 0.02
    if below:
        floor = ground.vertices - np.float32([0, 0, 1])
        faces = np.concatenate([faces, ground.faces + np.uint32(len(vertices))])
        vertices = np.concatenate([vertices, floor])
    return Mesh(vertices=vertices, faces=faces)


def loops_of(mesh):
    return border_loops(mesh.faces, len(mesh.vertices)).count


def test_a_folded_rim_is_replaced():
    mesh = with_hole(0.6)
    before = closed_surface(with_hole(0.6, turned=False), OPTIONS, None)
    assert (before.shadows, loops_of(before.mesh)) == (1, 1)
    made = closed_surface(mesh, OPTIONS, None)
    assert made.shadows == 1 and loops_of(made.mesh) == 1
    assert made.mesh.vertices[:, 2].max() == 0.0  # what lay on the ground is gone


def test_nothing_was_observed_in_a_shadow():
    mesh = with_hole(0.6, turned=False)
    seen = np.full(len(mesh.vertices), 7.0, np.float32)
    mesh = replace(mesh, vertex_attributes={"observations": seen})
    made = closed_surface(mesh, OPTIONS, None).mesh
    values = made.vertex_attributes["observations"]
    assert len(values) > len(seen) and (values[: len(seen)] == 7).all()
    assert values.dtype == np.float32 and not values[len(seen) :].any()


def test_the_rim_of_an_opening_stays():
    mesh = with_hole(0.6, below=True)
    made = closed_surface(mesh, OPTIONS, None)
    assert made.shadows == 0 and loops_of(made.mesh) == 3
    assert np.array_equal(made.mesh.faces, mesh.faces)
    wide = with_hole(1.6)
    assert np.array_equal(closed_surface(wide, OPTIONS, None).mesh.faces, wide.faces)


def test_none_are_closed_where_none_is_wanted():
    mesh = with_hole(0.6, turned=False)
    for options in ({"fill_holes": 0.0}, {"fill_shadows": 0.0}):
        made, changes = drivable(mesh, SurfaceOptions(min_component=20, **options))
        assert loops_of(made) == 2 and not changes.shadows and not changes.holes
    made, changes = drivable(mesh, SurfaceOptions(min_component=20))
    assert loops_of(made) == 1 and changes.shadows == 1
    assert changes.lines() == ["1 shadow closed by %d faces" % changes.shadow_faces]
