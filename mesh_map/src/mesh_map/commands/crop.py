"""mesh_tool crop: the part of a mesh that is in a region."""

import argparse
from dataclasses import replace
from functools import partial
from typing import List, Tuple

import numpy as np
from mesh_msgs_hdf5.commands.progress import ProgressLine
from mesh_msgs_hdf5.formats.base.options import NEEDED
from mesh_msgs_hdf5.labels.map_contents import read_map
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.mesh import Features, Mesh

from mesh_map.commands.derived_output import add_in_and_out, carried, check_in_and_out, saved
from mesh_map.commands.map_errors import as_map_errors
from mesh_map.geometry.crop import Region, crop

NAME = "crop"
HELP = (
    "keep the faces whose middle is in a box, between heights or in a polygon, with all they have"
)
EXAMPLE = "mesh_tool crop hall.h5 room.h5 --box 0,0,-0.5,6,4,3"

_ON_BORDER = 1e-6  # so near to it, in parts of the largest coordinate


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_in_and_out(parser)
    text = "two corners, in meters in the map's frame"
    parser.add_argument("--box", type=parsed_box, metavar="X,Y,Z,X,Y,Z", help=text)
    parser.add_argument("--z", type=_heights, metavar="LO,HI", help="heights in meters")
    text = "corners of a polygon seen from above, at least three"
    parser.add_argument("--polygon", type=_corner, nargs="+", metavar="X,Y", help=text)
    text = "keep what is outside instead: the region is cut out"
    parser.add_argument("--outside", action="store_true", help=text)


def _numbers(text: str, count: int) -> List[float]:
    values = [float(value) for value in text.split(",")]
    if len(values) != count or not np.isfinite(values).all():
        raise ValueError(text)
    return values


def parsed_box(text: str) -> Tuple[List[float], List[float]]:
    """(the lower, the upper corner) of a box. Raises ValueError for what is none."""
    corners = np.reshape(_numbers(text, 6), (2, 3))
    return corners.min(0).tolist(), corners.max(0).tolist()


def _heights(text: str) -> List[float]:
    return sorted(_numbers(text, 2))


def _corner(text: str) -> List[float]:
    return _numbers(text, 2)


parsed_box.__name__, _heights.__name__ = "box (X,Y,Z,X,Y,Z)", "heights (LO,HI)"
_corner.__name__ = "corner (X,Y)"


def run(arguments: argparse.Namespace) -> int:
    region = _region(arguments)
    check_in_and_out(arguments)
    with ProgressLine(arguments.quiet) as progress, as_map_errors(arguments.input):
        progress.stage("reading " + arguments.input)
        mesh, report = read_map(arguments.input, arguments.part, origin=NEEDED)
        before = len(mesh.faces)
        progress.stage("cropping")
        across = _across(mesh, region)
        result = carried(mesh, partial(crop, region=region), "crop", region.parameters())
        assert result is not None  # crop() refuses a region without faces
        result, left_out = _without_rest(result, region)
        notes = report.notes + left_out
        if across:
            text = (
                "%d faces lie across the border, and were kept or left as a whole by their middle"
            )
            notes.append(text % across + "; mesh_tool refine makes faces smaller")
        progress.stage("saving " + arguments.output)
        head = "%s: %d of %d faces" % (arguments.input, len(result.faces), before)
        return saved(arguments, result, notes, head)


def _region(arguments: argparse.Namespace) -> Region:
    low, high = np.full(3, -np.inf), np.full(3, np.inf)
    if arguments.box is not None:
        low, high = np.array(arguments.box)
    if arguments.z is not None:
        low[2], high[2] = max(low[2], arguments.z[0]), min(high[2], arguments.z[1])
    polygon = None if arguments.polygon is None else np.array(arguments.polygon)
    if polygon is not None and len(polygon) < 3:
        text = "a polygon has three corners at least, not %d" % len(polygon)
        raise MapFileError("value", arguments.input, text, "--polygon 0,0 4,0 4,3")
    if polygon is None and not (np.isfinite(low) | np.isfinite(high)).any():
        text = "there is no region to crop to"
        raise MapFileError("value", arguments.input, text, "--box, --z or --polygon")
    return Region(low, high, polygon, arguments.outside)


def _across(mesh: Mesh, region: Region) -> int:
    """How many faces have corners on both sides of the border, not only on it."""
    margin = _ON_BORDER * (1 + np.abs(mesh.vertices).max())
    wider = Region(region.low - margin, region.high + margin, region.polygon)
    narrower = Region(region.low + margin, region.high - margin, region.polygon)
    inside, outside = narrower.contains(mesh.vertices), ~wider.contains(mesh.vertices)
    across = inside[mesh.faces].any(1) & outside[mesh.faces].any(1)
    return int(np.count_nonzero(across))


def _without_rest(mesh: Mesh, region: Region) -> Tuple[Mesh, List[str]]:
    """Without what nothing of the region has: labels without faces, textures, features; notes."""
    notes = []
    empty = [text for text, label in mesh.labels.items() if not len(label.faces)]
    if empty:
        shown = ", ".join(empty[:5]) + (", ..." if len(empty) > 5 else "")
        notes.append("left out: %d labels without faces in the region (%s)" % (len(empty), shown))
        labels = {text: label for text, label in mesh.labels.items() if text not in empty}
        mesh = replace(mesh, labels=labels)
    if mesh.materials is not None:
        used = np.unique(mesh.materials.face_materials)
        indices = np.full_like(mesh.materials.texture_indices, -1)
        indices[used] = mesh.materials.texture_indices[used]
        textures = {i: image for i, image in mesh.textures.items() if i in indices}
        if len(textures) < len(mesh.textures):
            count = len(mesh.textures) - len(textures)
            notes.append("left out: %d textures of faces outside" % count)
            materials = replace(mesh.materials, texture_indices=indices)
            mesh = replace(mesh, textures=textures, materials=materials)
    if mesh.features is not None:
        there = region.contains(mesh.features.locations)
        mesh.features = Features(mesh.features.locations[there], mesh.features.descriptors[there])
        if not there.any():
            mesh.features = None
    return mesh, notes
