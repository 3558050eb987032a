"""mesh_tool simplify: fewer faces, with borders and labels as they are."""

import argparse
from dataclasses import replace
from typing import Any, Optional

import numpy as np
from mesh_msgs.derived_mesh import DerivedMesh
from mesh_msgs_hdf5.commands.progress import ProgressLine
from mesh_msgs_hdf5.formats.base.options import NEEDED
from mesh_msgs_hdf5.labels.map_contents import read_map
from mesh_msgs_hdf5.model.mesh import Mesh
from mesh_msgs_hdf5.model.seams import split_mesh

from mesh_map.commands.derived_output import (
    add_in_and_out,
    carried_to,
    check_in_and_out,
    interpolated_layers,
    saved,
)
from mesh_map.commands.map_errors import as_map_errors
from mesh_map.geometry.simplification import simplify

NAME = "simplify"
HELP = "fewer faces within an error; borders, and those of labels and materials, stay as they are"
EXAMPLE = "mesh_tool simplify yard.h5 yard_light.h5 --max-error 0.02"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_in_and_out(parser)
    add = parser.add_argument
    text = "meters: no vertex of IN is farther from OUT.h5"
    add("--max-error", type=float, default=np.inf, metavar="M", help=text)
    how_many = parser.add_mutually_exclusive_group()
    text = "so many faces are enough"
    how_many.add_argument("--faces", type=int, metavar="N", help=text)
    text = "such a part of the faces is enough, above 0 to 1"
    how_many.add_argument("--ratio", type=float, metavar="X", help=text)


def run(arguments: argparse.Namespace) -> int:
    check_in_and_out(arguments)
    with ProgressLine(arguments.quiet) as progress, as_map_errors(arguments.input):
        progress.stage("reading " + arguments.input)
        mesh, report = read_map(arguments.input, arguments.part, origin=NEEDED)
        notes, before = list(report.notes), len(mesh.faces)
        progress.stage("simplifying")
        options = {
            "max_error": arguments.max_error,
            "face_count": arguments.faces,
            "ratio": arguments.ratio,
        }
        split = split_mesh(mesh)
        originals = None
        if split is not None:
            originals = np.arange(len(mesh.vertices))
            originals[len(mesh.parent_vertices) :] = split.originals
        identity = mesh.parent_uuid or mesh.uuid
        regions = _regions(mesh)
        done = simplify(
            mesh.vertices,
            mesh.faces,
            regions=regions,
            originals=originals,
            parent_uuid=identity,
            **options,
        )
        if done.derived is None:
            notes.append("no face could be spared: the mesh is as it was")
        else:
            mesh = _simplified(mesh, done.derived, _shown(options))
            notes += interpolated_layers(mesh)
        if done.kept_faces:
            text = "%d faces were kept, where fewer would have folded up, or been too far away"
            notes.append(text % done.kept_faces)
        progress.stage("saving " + arguments.output)
        text = "%s: %d faces became %d, %.3g m away at most"
        head = text % (arguments.input, before, len(mesh.faces), done.max_distance)
        more = {"max_distance": done.max_distance, "kept_faces": done.kept_faces}
        return saved(arguments, mesh, notes, head, more)


def _shown(options: Any) -> Any:
    """What json can write of those that were given."""
    return {name: v for name, v in options.items() if v is not None and v != np.inf}


def _regions(mesh: Mesh) -> Optional[np.ndarray]:
    """(F,) faces with the same labels and the same material have the same number; None for all.

    Each label adds a random number of 64 bits, so that any number of labels may overlap.
    """
    regions = np.zeros(len(mesh.faces), np.uint64)
    if mesh.materials is not None:
        regions[:] = mesh.materials.face_materials
    keys = np.random.default_rng(0).integers(1, 2**63, len(mesh.labels), np.uint64)
    for key, label in zip(keys, mesh.labels.values()):
        regions[np.unique(label.faces)] += key
    return regions if regions.any() else None


def _simplified(mesh: Mesh, derived: DerivedMesh, parameters: Any) -> Mesh:
    """All that the mesh has, on fewer faces; copies along seams stay the last vertices."""
    result = carried_to(mesh, derived, "simplification", parameters)
    split = split_mesh(mesh)
    if split is None:
        return result
    count = len(mesh.parent_vertices)
    kept = derived.vertex_parents[:, 0].astype(np.int64)
    numbers = np.full(len(mesh.vertices), -1, np.int64)
    numbers[kept] = np.arange(len(kept))
    originals = numbers[split.originals[kept[kept >= count] - count]]
    return replace(result, seam_originals=originals.astype(np.uint32) if len(originals) else None)
