"""mesh_tool compare: how far a map is from the truth, how complete, and how sound it is."""

import argparse
from typing import Any, Dict, List, Optional

import numpy as np
from mesh_msgs_hdf5.commands._common import add_output_options, add_part, check_output, say
from mesh_msgs_hdf5.commands.progress import ProgressLine
from mesh_msgs_hdf5.files.save import save_file
from mesh_msgs_hdf5.formats.base.options import NEEDED
from mesh_msgs_hdf5.labels.map_contents import read_map
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.mesh import Mesh
from mesh_msgs_hdf5.rendering.render_camera import VIEWS, parsed_view, usual_view
from mesh_msgs_hdf5.rendering.render_figure import picture_png
from mesh_msgs_hdf5.rendering.render_paint import VertexValues
from mesh_msgs_hdf5.rendering.render_scale import SCALES

from mesh_map.commands.crop import parsed_box
from mesh_map.commands.map_errors import as_map_errors
from mesh_map.geometry.crop import Region
from mesh_map.geometry.mesh_comparison import SAMPLES, MeshComparison, compare_meshes
from mesh_map.geometry.topology import quantity
from mesh_map.spatial.spatial_index import SpatialIndex

NAME = "compare"
HELP = "how far a map is from the truth, how much of that it has, and how sound it is"
EXAMPLE = "mesh_tool compare truth.h5 map.h5 --picture error.png"
_SIZE = (1200, 900)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add("truth", metavar="TRUTH", help="a map file, or any mesh that import reads")
    add("input", metavar="MAP", help="the same, in the same frame: what is measured")
    text = "meters: what is nearer counts as found (default: %(default)s)"
    add("--tolerance", type=float, default=0.05, metavar="M", help=text)
    text = "points on each surface, spread by area (default: %(default)s)"
    add("--samples", type=int, default=SAMPLES, metavar="N", help=text)
    add("--seed", type=int, default=0, metavar="N", help="of the points (default: %(default)s)")
    text = "only points in this box count: two corners, in meters in the frame of TRUTH"
    add("--within", type=parsed_box, metavar="X,Y,Z,X,Y,Z", help=text)
    text = "an attribute of the faces of TRUTH: what is not 0 was seen, and has to be there"
    add("--reached", metavar="NAME", help=text)
    text = "draw MAP, colored by its distance from TRUTH"
    add("--picture", metavar="OUT.png", help=text)
    text = "of the picture: %s, or AZIMUTH,ELEVATION in degrees" % ", ".join(VIEWS)
    add("--view", type=parsed_view, help=text)
    add("--force", action="store_true", help="replace OUT.png if it exists")
    add_part(parser, "MAP, if it is a map with several")
    text = "the same of TRUTH"
    add("--truth-part", metavar="NAME", help=text)
    add_output_options(parser)


def run(arguments: argparse.Namespace) -> int:
    if arguments.picture is not None:
        check_output(arguments.input, arguments.picture, arguments.force, (".png",))
    with ProgressLine(arguments.quiet) as progress, as_map_errors(arguments.input):
        progress.stage("reading " + arguments.truth)
        truth, truth_report = read_map(arguments.truth, arguments.truth_part, origin=NEEDED)
        progress.stage("reading " + arguments.input)
        mesh, report = read_map(arguments.input, arguments.part, origin=NEEDED)
        notes = list(dict.fromkeys(truth_report.notes + report.notes))
        vertices = _in_frame_of(truth, mesh, arguments, notes)
        progress.stage("comparing")
        found = compare_meshes(
            truth.parent_vertices,
            truth.parent_faces,
            vertices[: len(mesh.parent_vertices)],
            mesh.parent_faces,
            tolerance=arguments.tolerance,
            samples=arguments.samples,
            seed=arguments.seed,
            within=None if arguments.within is None else Region(*np.array(arguments.within)),
            reached=_reached(truth, arguments),
        )
        if arguments.picture is not None:
            progress.stage("drawing")
            png = _picture(truth, mesh, vertices, found, arguments)
            save_file(arguments.picture, png, overwrite=arguments.force)
    value = {
        "truth": arguments.truth,
        "input": arguments.input,
        "tolerance": arguments.tolerance,
        "notes": notes,
        **_named(found.values()),
    }
    say(arguments, value, [*_lines(found, arguments), *("  note: " + note for note in notes)])
    return 0


def _named(values: Dict[str, Any]) -> Dict[str, Any]:
    """ "truth" and "input" are the files already."""
    values["soundness"] = {"truth": values.pop("truth"), "map": values.pop("mesh")}
    return values


def _in_frame_of(
    truth: Mesh, mesh: Mesh, arguments: argparse.Namespace, notes: List[str]
) -> np.ndarray:
    """(V, 3) the vertices of the map in the frame of the truth: origins may differ."""
    if truth.crs and mesh.crs and truth.crs != mesh.crs:
        text = "the truth is in %s, the map in %s" % (truth.crs, mesh.crs)
        raise MapFileError("value", arguments.input, text, "bring both into one reference system")
    if truth.frame_id != mesh.frame_id:
        text = "frames have different names, taken for the same: %s and %s"
        notes.append(text % (truth.frame_id, mesh.frame_id))
    offset = np.subtract(_origin(mesh), _origin(truth))
    if not offset.any():
        return mesh.vertices
    return (mesh.vertices + offset).astype(np.float32)


def _origin(mesh: Mesh) -> np.ndarray:
    return np.zeros(3) if mesh.origin is None else np.asarray(mesh.origin, np.float64)


def _reached(truth: Mesh, arguments: argparse.Namespace) -> Optional[np.ndarray]:
    name = arguments.reached
    if name is None:
        return None
    values = truth.face_attributes.get(name)
    if values is None or values.size != len(truth.faces):
        known = ", ".join(sorted(truth.face_attributes)) or "none"
        text = "there is no attribute %r of one value per face" % name
        raise MapFileError("value", arguments.truth, text, "there are: " + known)
    return values.reshape(-1) != 0


def _picture(
    truth: Mesh,
    mesh: Mesh,
    vertices: np.ndarray,
    found: MeshComparison,
    arguments: argparse.Namespace,
) -> bytes:
    index = SpatialIndex(truth.vertices, truth.faces)
    distances = index.closest_batch(points=vertices).distances.astype(np.float32)
    limits = (0.0, 2.0 * arguments.tolerance)
    paint = VertexValues(
        "distance from truth [m]", mesh.faces, distances, SCALES["rainbow"], limits
    )
    view = arguments.view or usual_view(mesh.vertices, mesh.faces)
    title = "%s: mean %s, 95 %% within %s, %.1f %% complete" % (
        arguments.input.rsplit("/", 1)[-1],
        _length(found.accuracy.mean),
        _length(found.accuracy.p95),
        100.0 * found.completeness.share_within,
    )
    return picture_png(mesh, paint, view, _SIZE, title)


def _length(meters: float) -> str:
    return "%.3g m" % meters if meters >= 1.0 else "%.3g mm" % round(1000.0 * meters, 3)


def _lines(found: MeshComparison, arguments: argparse.Namespace) -> List[str]:
    within = _length(arguments.tolerance)
    lines = ["%s, measured against %s" % (arguments.input, arguments.truth)]
    for name, distances in (("accuracy", found.accuracy), ("completeness", found.completeness)):
        lines.append(
            "  %s: mean %s, 95 %% within %s, at most %s; %.2f %% within %s"
            % (
                name,
                _length(distances.mean),
                _length(distances.p95),
                _length(distances.max),
                100.0 * distances.share_within,
                within,
            )
        )
    lines.append("  normals to the other side: %.2f %%" % (100.0 * found.share_flipped))
    for name, sound in (("map", found.mesh), ("truth", found.truth)):
        parts = (
            quantity(sound.faces, "faces"),
            quantity(sound.components, "components"),
            "%.2f %% of the faces outside the largest" % (100.0 * sound.share_outside_largest),
            quantity(sound.border_loops, "border loops"),
            quantity(sound.open_border_edges, "border edges") + " in none",
            quantity(sound.non_manifold_edges, "non-manifold edges"),
            quantity(sound.inconsistent_edges, "edges") + " of faces that disagree",
        )
        lines.append("  %s: %s" % (name, ", ".join(parts)))
    return lines
