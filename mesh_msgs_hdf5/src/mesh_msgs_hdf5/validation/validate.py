"""Everything that is wrong or odd about a mesh file, as findings."""
from typing import Any, Callable, Dict, Iterator, List, Optional

import numpy as np
from mesh_msgs.identity import geometry_uuid

from mesh_msgs.text import one_line
from mesh_msgs_hdf5.formats.any_mesh import Members, is_map_file, open_members
from mesh_msgs_hdf5.formats.base.equal_rows import by_appearance, equal_rows
from mesh_msgs_hdf5.isolation import isolated
from mesh_msgs_hdf5.map_file.writing.lvr2_part import lvr2_part_name
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.mesh import Mesh
from mesh_msgs_hdf5.validation.findings import ERROR, NOTE, WARNING, MapFinding
from mesh_msgs_hdf5.validation.validate_beside import check_journal, check_temporaries
from mesh_msgs_hdf5.validation.validate_shape import check_shape
from mesh_msgs_hdf5.validation.validate_topology import check_topology
from mesh_msgs_hdf5.validation.validate_values import (
    check_attribute,
    check_labels,
    check_layer,
    check_textures,
)

_SINGLE = ("frame_id", "origin", "crs", "source", "vertices", "faces", "vertex_normals")
_SINGLE += ("vertex_colors", "texture_coordinates", "materials", "features", "seam_originals")


def validate(
    path: str, part: Optional[str] = None, progress: Callable[[str], None] = lambda stage: None
) -> List[MapFinding]:
    """Findings about a file of any known format; never raises for what is in the file.

    Every member is read, a map file in a process of its own. part: of a map; None: all its parts.
    progress: is told each stage.
    """
    progress("reading")
    try:
        is_map = is_map_file(path)
        parts = isolated("parts", path) if is_map and part is None else [part]
    except MapFileError as error:
        return [_error("file", error)]
    findings = list(check_temporaries(path)) if is_map else []
    if not parts:
        parts = [None]  # the error says what it lacks
    for name in parts:
        found = _validate_part(path, name, progress)
        if len(parts) > 1:
            place = one_line(name or "/") + ": "
            found = [finding._replace(where=place + finding.where) for finding in found]
        findings += found
    if is_map:
        progress("checking the scans")
        findings += _scans(path)
    return sorted(findings, key=lambda finding: (ERROR, WARNING, NOTE).index(finding.level))


def _scans(path) -> Iterator[MapFinding]:
    try:
        for code, name, message in isolated("check_scans", path):
            # points that are not finite are how many sensors say that they saw nothing
            level = NOTE if code == "not_finite" else ERROR
            yield MapFinding(code, level, "scan " + one_line(name), one_line(message))
        others = isolated("other_scan_groups", path)
        if others:
            text = "groups below /raw/scans are no scans by their names, first %s" % one_line(
                others[0]
            )
            yield MapFinding("scan_name", NOTE, "scans", text, None, len(others))
    except MapFileError as error:
        yield _error("scans", error)


def _validate_part(path, part, progress) -> List[MapFinding]:
    try:
        file, form, notes, _ = open_members(path, part, strict=True)
    except MapFileError as error:
        return [_error("file", error)]
    findings = [MapFinding("import", NOTE, "file", note) for note in notes]
    with file:
        return findings + _validate_members(file, form, progress)


def _validate_members(file: Members, form, progress) -> List[MapFinding]:
    findings: List[MapFinding] = []
    members = _read_all(file, findings, progress)
    vertices, faces = members.get("vertices"), members.get("faces")
    if vertices is not None and faces is not None:
        if form == "HDF5":
            progress("checking the uuid")
            findings += _uuid(file, vertices, faces)
            findings += _lvr2(file)
            findings += check_journal(file)
        # copies along seams of textures are one vertex
        whole = Mesh(vertices, faces, seam_originals=members.get("seam_originals"))
        vertices, faces = whole.parent_vertices, whole.parent_faces
        rows = np.arange(len(vertices))
        if any(finding.where == "seam_originals" for finding in findings):
            # which are copies is not known: those at one place, so that no seam is a border
            rows, group = by_appearance(*equal_rows((vertices + np.float32(0)).T))
            vertices, faces = vertices[rows], group[faces].astype(np.uint32)
        progress("checking the faces")
        findings += check_topology(len(vertices), faces)
        progress("checking the shape")
        normals = members.get("vertex_normals")
        findings += check_shape(vertices, faces, None if normals is None else normals[rows])
    coordinates, materials = (members.get(key) for key in ("texture_coordinates", "materials"))
    # what cannot be read is there, and has no consequences of its own
    unread = {finding.where for finding in findings if finding.level == ERROR}
    if not unread & {"materials", "texture_coordinates", "textures"}:
        findings += check_textures(members.get("textures", ()), materials, coordinates)
    return findings


def _error(where, error: MapFileError) -> MapFinding:
    hint = " (%s)" % error.hint if error.hint else ""
    return MapFinding(error.code, ERROR, where, one_line(error.message + hint))


def _read_all(file: Members, findings, progress) -> Dict[str, Any]:
    """What could be read of the members that later checks need; the rest became findings."""
    members: Dict[str, Any] = {}

    def read(where, call, *arguments):
        progress("reading " + where)
        try:
            return call(*arguments)
        except MapFileError as error:
            findings.append(_error(where, error))
            return None

    for name in _SINGLE:
        members[name] = read(name, getattr, file, name)
    for name in read("layers", file.layer_names) or ():
        where = "layer " + one_line(name)
        costs = read(where, file.vertex_costs, name)
        read(where, file.layer_parameters, name)
        findings += check_layer(name, costs) if costs is not None else ()
    for place, names, attribute, parameters in (
        ("vertex", file.vertex_attribute_names, file.vertex_attribute, file.vertex_parameters),
        ("face", file.face_attribute_names, file.face_attribute, file.face_parameters),
    ):
        for name in read(place + " attributes", names) or ():
            where = "%s attribute %s" % (place, one_line(name))
            values = read(where, attribute, name)
            read(where, parameters, name)
            findings += check_attribute(place, name, values) if values is not None else ()
    members["textures"] = read("textures", file.texture_indices) or ()
    for index in members["textures"]:
        read("texture %d" % index, file.texture, index)
    labels = {}
    for text in read("labels", file.label_names) or ():
        label = read("label " + one_line(text), file.label, text)
        if label is not None:
            labels[text] = label
    findings += check_labels(labels, file.face_count)
    read("other contents", file.other_contents)
    return members


def _lvr2(file: Members) -> List[MapFinding]:
    """A note if LVR2's programs cannot read this part, and have none of their own beside it."""
    if file.textures_form != "hdf5_map_io" or lvr2_part_name(file.part) in file.parts:
        return []
    text = "LVR2's MeshIO ends over textures and materials in this form: mesh_tool convert --for "
    text += "lvr2 makes a file for it, in which hdf5_map_io finds no materials; --for both one for "
    text += "both"
    return [MapFinding("lvr2_textures", NOTE, "textures", text)]


def _uuid(file: Members, vertices: np.ndarray, faces: np.ndarray) -> List[MapFinding]:
    try:
        stored = file.stored_uuid
    except MapFileError as error:
        return [_error("uuid", error)]
    if stored is None:
        text = "the file does not say its UUID (mesh_tool convert adds it)"
        return [MapFinding("uuid_missing", WARNING, "uuid", text)]
    actual = geometry_uuid(vertices, faces)
    if stored == actual:
        return []
    text = "it is %s, but vertices and faces are those of %s" % (one_line(stored), actual)
    # a UUID of other people need not be made from the geometry
    level = ERROR if file.schema_version else WARNING
    return [MapFinding("uuid_mismatch", level, "uuid", text)]
