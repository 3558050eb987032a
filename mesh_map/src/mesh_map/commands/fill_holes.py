"""mesh_tool fill-holes: short, flat loops of the border closed."""

import argparse
from dataclasses import replace
from functools import partial
from typing import Any, List, Optional, Tuple

import numpy as np
from mesh_msgs.derived_mesh import DerivedMesh
from mesh_msgs_hdf5.commands.progress import ProgressLine
from mesh_msgs_hdf5.formats.base.options import NEEDED
from mesh_msgs_hdf5.labels.map_contents import read_map
from mesh_msgs_hdf5.model.mesh import Materials, Mesh

from mesh_map.commands.derived_output import (
    add_in_and_out,
    carried,
    check_in_and_out,
    interpolated_layers,
    saved,
)
from mesh_map.commands.map_errors import as_map_errors
from mesh_map.geometry.components import drop_components
from mesh_map.geometry.hole_filling import HoleFilling, fill_holes
from mesh_map.geometry.manifold import Manifold, make_manifold
from mesh_map.geometry.topology import quantity

NAME = "fill-holes"
HELP = "close holes that are short and flat; doorways and the outer border stay open"
EXAMPLE = "mesh_tool fill-holes yard.h5 yard_closed.h5 --max-perimeter 1.5"
_GRAY = (128, 128, 128, 255)  # of faces that close holes of a mesh with textures


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_in_and_out(parser)
    add = parser.add_argument
    text = "meters: only shorter loops are closed (default: %(default)s)"
    add("--max-perimeter", type=float, default=1.0, metavar="M", help=text)
    text = "how far a loop may leave its best plane, in parts of its perimeter (%(default)s)"
    add("--flatness", type=float, default=0.1, metavar="X", help=text)
    text = "degrees: loops whose best plane is steeper stay open, such as windows (%(default)s)"
    add("--max-slope", type=float, default=90.0, metavar="DEG", help=text)
    add("--coarse", action="store_true", help="no new vertices, faces from border to border")
    text = "before: cut edges of more than two faces, and turn faces so that neighbors agree"
    add("--repair", action="store_true", help=text)
    text = "before: drop components of fewer faces"
    add("--min-faces", type=int, default=0, metavar="N", help=text)


def run(arguments: argparse.Namespace) -> int:
    check_in_and_out(arguments)
    with ProgressLine(arguments.quiet) as progress, as_map_errors(arguments.input):
        progress.stage("reading " + arguments.input)
        mesh, report = read_map(arguments.input, arguments.part, origin=NEEDED)
        notes, before = list(report.notes), mesh
        mesh = _prepared(mesh, arguments, progress, notes)
        progress.stage("closing holes")
        options = {
            "max_perimeter": arguments.max_perimeter,
            "flatness": arguments.flatness,
            "max_slope": arguments.max_slope,
            "refine": not arguments.coarse,
        }
        done: List[HoleFilling] = []

        def derive(*mesh_arrays: Any, **identity: Any) -> Optional[DerivedMesh]:
            done.append(fill_holes(*mesh_arrays, **options, **identity))
            return done[0].derived

        result = carried(mesh, derive, "holes filled", options)
        if result is not None:
            result, more = _without_texture(result, done[0].new_faces)
            mesh, notes = result, notes + more
        if mesh is not before:
            notes += interpolated_layers(mesh)
        progress.stage("saving " + arguments.output)
        head = "%s: %s" % (arguments.input, done[0].report())
        more_values = {"loops": done[0].counts(), "new_faces": int(done[0].new_faces.sum())}
        return saved(arguments, mesh, notes, head, more_values)


def _prepared(
    mesh: Mesh, arguments: argparse.Namespace, progress: ProgressLine, notes: List[str]
) -> Mesh:
    """Repaired and without small components, where that is asked for."""
    if arguments.repair:
        progress.stage("repairing")
        repaired: List[Manifold] = []

        def derive(*mesh_arrays: Any, **identity: Any) -> Optional[DerivedMesh]:
            repaired.append(make_manifold(*mesh_arrays, **identity))
            return repaired[0].derived

        mesh = carried(mesh, derive, "manifold", {}) or mesh
        notes.append("repaired: " + repaired[0].report())
    if arguments.min_faces > 0:
        progress.stage("dropping components")
        count = len(mesh.faces)
        parameters = {"min_faces": arguments.min_faces}
        mesh = (
            carried(mesh, partial(drop_components, **parameters), "components", parameters) or mesh
        )
        dropped = count - len(mesh.faces)
        notes.append("dropped: %s of small components" % quantity(dropped, "faces"))
    return mesh


def _without_texture(mesh: Mesh, new_faces: np.ndarray) -> Tuple[Mesh, List[str]]:
    """New faces in gray where the mesh has textures, which show nothing of what was not there."""
    materials = mesh.materials
    if materials is None or not mesh.textures:
        return mesh, []
    gray = np.array([_GRAY], materials.colors.dtype)[:, : materials.colors.shape[1]]
    face_materials = materials.face_materials.copy()
    face_materials[new_faces] = len(materials.colors)
    colors = np.concatenate([materials.colors, gray])
    indices = np.append(materials.texture_indices, -1).astype(materials.texture_indices.dtype)
    note = "without texture, in gray: the %s that close holes" % quantity(
        int(new_faces.sum()), "faces"
    )
    return replace(mesh, materials=Materials(colors, indices, face_materials)), [note]
