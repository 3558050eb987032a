"""A scene of parts with vertices of their own (COLLADA, glTF), and one mesh made of it."""
from dataclasses import dataclass, field, replace
from typing import Dict, List, Optional, Tuple

import numpy as np

from mesh_msgs_hdf5.formats.base.corners import agreed, texture_vertices
from mesh_msgs_hdf5.formats.base.movement import mirrors, moved_normals, moved_positions
from mesh_msgs_hdf5.formats.base.options import Options, placed
from mesh_msgs_hdf5.formats.base.polygons import triangle_edges, weld
from mesh_msgs_hdf5.formats.base.report import ImportReport
from mesh_msgs_hdf5.formats.base.values import (
    add_attribute,
    add_layer,
    coordinates_or_none,
    normals_or_none,
)
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike
from mesh_msgs_hdf5.model.mesh import Mesh

# vertices and faces together: a small file may show one part again and again
MAX_TOTAL = 1 << 26


@dataclass
class ScenePart:
    """Triangles with vertices of their own.

    positions: (N, 3) float; faces: (F, 3) int64, below N; materials: (F,) int64; normals: (N, 3);
    colors: (N, 3) uint8; coordinates: (N, 2) float32; layers: name -> (N,); attributes: name ->
    (N, C) of any numbers.
    """

    positions: np.ndarray
    faces: np.ndarray
    materials: np.ndarray
    normals: Optional[np.ndarray] = None
    colors: Optional[np.ndarray] = None
    coordinates: Optional[np.ndarray] = None
    layers: Dict[str, np.ndarray] = field(default_factory=dict)
    attributes: Dict[str, np.ndarray] = field(default_factory=dict)

    def moved(self, transform: np.ndarray) -> "ScenePart":
        """The part after a 4 x 4 transform; where that mirrors, outside stays outside."""
        if np.array_equal(transform, np.eye(4)):
            return self
        faces, normals = self.faces, self.normals
        positions, _ = moved_positions(self.positions, (0.0, 0.0, 0.0), transform)
        if mirrors(transform):
            faces = faces[:, ::-1]
        if normals is not None:
            normals = moved_normals(normals, transform)
        return replace(self, positions=positions, faces=faces, normals=normals)


@dataclass
class Scene:
    """All parts as one: arrays as in ScenePart.

    known: (N,) bool, which vertices have texture coordinates; face_materials: (F,).
    """

    positions: np.ndarray
    faces: np.ndarray
    face_materials: np.ndarray
    normals: Optional[np.ndarray] = None
    colors: Optional[np.ndarray] = None
    coordinates: Optional[np.ndarray] = None
    known: Optional[np.ndarray] = None
    layers: Dict[str, np.ndarray] = field(default_factory=dict)
    attributes: Dict[str, np.ndarray] = field(default_factory=dict)


def check_scene_size(path: PathLike, total: int) -> None:
    """Refuse a scene of more vertices and faces than MAX_TOTAL."""
    if total > MAX_TOTAL:
        raise MapFileError(
            "size",
            path,
            "the scene has more than %d vertices and faces" % MAX_TOTAL,
            "export the parts that are needed",
        )


def joined(parts: List[ScenePart], report: ImportReport) -> Scene:
    """One scene of all parts.

    Where only some have colors the others are white, where only some have a layer the others are
    unknown there; normals need all, and attributes, in the same type.
    """
    rows = [len(part.positions) for part in parts]
    starts = np.cumsum([0] + rows)[:-1]
    if not parts:
        none = np.zeros((0, 3))
        return Scene(none, none.astype(np.int64), none[:, 0].astype(np.int64))

    def filled(values, width, fill, dtype):
        shapes = [(n,) + ((width,) if width else ()) for n in rows]
        return np.concatenate(
            [np.full(s, fill, dtype) if v is None else v for v, s in zip(values, shapes)]
        )

    have = {
        name: [getattr(part, name) is not None for part in parts]
        for name in ("normals", "colors", "coordinates")
    }
    if any(have["normals"]) and not all(have["normals"]):
        report.note("normals left out: %d parts have none", have["normals"].count(False))
    if any(have["colors"]) and not all(have["colors"]):
        report.note("white where there is no color: %d parts", have["colors"].count(False))
    names = list(dict.fromkeys(name for part in parts for name in part.layers))
    textured = any(have["coordinates"])
    return Scene(
        np.concatenate([part.positions for part in parts]),
        np.concatenate([part.faces + start for part, start in zip(parts, starts)]),
        np.concatenate([part.materials for part in parts]),
        np.concatenate([part.normals for part in parts]) if all(have["normals"]) else None,
        filled([part.colors for part in parts], 3, 255, np.uint8) if any(have["colors"]) else None,
        filled([part.coordinates for part in parts], 2, 0, np.float32) if textured else None,
        np.repeat(have["coordinates"], rows) if textured else None,
        {
            name: filled([part.layers.get(name) for part in parts], 0, np.nan, np.float32)
            for name in names
        },
        _joined_attributes(parts, report),
    )


def _joined_attributes(parts, report):
    found = {}
    for name in dict.fromkeys(name for part in parts for name in part.attributes):
        values = [part.attributes.get(name) for part in parts]
        if len({None if v is None else (v.dtype, v.shape[1:]) for v in values}) == 1:
            found[name] = np.concatenate(values)
        else:
            report.note("attribute %s left out: %d parts have none like it", name, _others(values))
    return found


def _others(values):
    first = next(v for v in values if v is not None)
    return sum(
        v is None or (v.dtype, v.shape[1:]) != (first.dtype, first.shape[1:]) for v in values
    )


def z_up(vectors: Optional[np.ndarray]) -> Optional[np.ndarray]:
    """(N, 3) of axes x right, y up, z to the viewer as x, -z, y."""
    if vectors is None:
        return None
    return np.stack([vectors[:, 0], -vectors[:, 2], vectors[:, 1]], axis=1)


def unwelded_mesh(
    path: PathLike,
    scene: Scene,
    options: Options,
    report: ImportReport,
    offset: Tuple[float, float, float],
) -> Mesh:
    """A Mesh with the vertices of the scene as they are."""
    vertices, origin = placed(
        path,
        scene.positions,
        "vertex",
        options,
        report,
        offset,
        lambda: triangle_edges(scene.faces),
    )
    mesh = Mesh(vertices, scene.faces.astype(np.uint32), vertex_colors=scene.colors, origin=origin)
    if scene.normals is not None:
        mesh.vertex_normals = normals_or_none(scene.normals, report)
    if scene.coordinates is not None:
        mesh.texture_coordinates = coordinates_or_none(scene.coordinates, mesh.faces, report)
    for name, values in scene.layers.items():
        add_layer(path, mesh, name, values, report)
    for name, values in scene.attributes.items():
        add_attribute(path, mesh, "vertex", name, _narrow(values), report)
    return mesh


def _narrow(values):
    """One column as (N,)."""
    return values[:, 0] if values.shape[1] == 1 else values


def welded_mesh(path: PathLike, scene: Scene, options: Options, report: ImportReport) -> Mesh:
    """A Mesh in which vertices at exactly the same position are one, in the order of the faces.

    Normals, colors and layers are kept where those that fell together agree; texture coordinates
    as texture_vertices says. Everything else is noted.
    """
    # the vertices that faces refer to, in the order in which they come first
    named, first = np.unique(scene.faces, return_index=True)
    rows = named[np.argsort(first, kind="stable")]
    number = np.zeros(len(scene.positions), np.int64)
    number[rows] = np.arange(len(rows))
    if len(rows) < len(scene.positions):
        report.note("left out: %d vertices without faces", len(scene.positions) - len(rows))
    positions, origin = placed(
        path,
        scene.positions[rows],
        "corner",
        options,
        report,
        edges=lambda: triangle_edges(number[scene.faces]),
    )
    vertices, index = weld(positions, report)
    mesh = Mesh(vertices, index[number[scene.faces]].astype(np.uint32), origin=origin)

    def taken(values, what):
        found = agreed(index, values[rows], len(vertices))
        if found is None:
            report.note("%s left out: corners that were welded have different ones", what)
        return found

    if scene.normals is not None:
        with np.errstate(over="ignore"):
            normals = taken(scene.normals.astype(np.float32), "normals")
        mesh.vertex_normals = None if normals is None else normals_or_none(normals, report)
    if scene.colors is not None:
        mesh.vertex_colors = taken(scene.colors, "colors")
    for name, values in scene.layers.items():
        costs = taken(values, "layer %s" % name)
        if costs is not None:
            add_layer(path, mesh, name, costs, report)
    for name, values in scene.attributes.items():
        values = taken(values, "attribute %s" % name)
        if values is not None:
            add_attribute(path, mesh, "vertex", name, _narrow(values), report)
    if scene.coordinates is not None and scene.known is not None:
        known = scene.known[rows]
        found = texture_vertices(
            index,
            scene.coordinates[rows],
            None if known.all() else known,
            len(vertices),
            number[scene.faces],
            options.split_seams is not False,
            report,
        )
        return found.given_to(mesh, found.index[number[scene.faces]])
    return mesh
