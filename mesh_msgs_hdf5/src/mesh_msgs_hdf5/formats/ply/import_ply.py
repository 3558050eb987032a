"""PLY to Mesh: vertex order and count are kept."""
import numpy as np
from mesh_msgs.split_mesh import copies_fault

from mesh_msgs_hdf5.formats.base.options import Options, placed
from mesh_msgs_hdf5.formats.base.polygons import (
    check_corners,
    polygon_edges,
    strip_triangles,
    triangulate,
)
from mesh_msgs_hdf5.formats.base.remarks import (
    about,
    mark_foreign_layers,
    parameters_of,
    parsed_remarks,
    remarked_origin,
    take_mesh_remark,
)
from mesh_msgs_hdf5.formats.base.report import ImportReport
from mesh_msgs_hdf5.formats.base.values import (
    add_attribute,
    add_layer,
    colors_or_none,
    coordinates_or_none,
    normals_or_none,
)
from mesh_msgs_hdf5.formats.ply.ply_faces import CORNERS, SEAMS, FaceReader, own_attribute
from mesh_msgs_hdf5.formats.ply.ply_file import Element, PlyFile, columns, read_elements
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike
from mesh_msgs_hdf5.model.mesh import Mesh

POSITION, NORMAL = ("x", "y", "z"), ("nx", "ny", "nz")
COLORS = (("red", "green", "blue"), ("diffuse_red", "diffuse_green", "diffuse_blue"))
TEXTURE = (("s", "t"), ("u", "v"), ("texture_u", "texture_v"), ("texture_s", "texture_t"))
# numbers that are no costs, even where they stand alone; flags are MeshLab's marks of its own
NO_LAYERS = frozenset(["alpha", "diffuse_alpha", "flags"]).union(NORMAL, *COLORS, *TEXTURE)


def read_ply(path: PathLike, data: bytes, options: Options, report: ImportReport) -> Mesh:
    """A Mesh of a PLY file's bytes.

    Properties of the vertices become colors (red, green, blue: bytes, or floats from 0 to 1),
    normals, texture coordinates and layers; those of the faces, see ply_faces. What our export
    wrote into comments comes back.
    """
    file = read_elements(path, data)
    vertex = file.elements.get("vertex")
    if vertex is None or not set(POSITION) <= set(vertex.values):
        raise MapFileError(
            "format",
            path,
            "the PLY file has no vertices with x, y and z",
            "export the mesh again where it was made",
        )
    remarks = parsed_remarks(file.comments, report)
    positions = columns(vertex, POSITION)
    _take_strips(path, file, report)
    counts, corners = _polygons(path, file.elements.get("face"), len(positions))
    vertices, origin = placed(
        path,
        positions,
        "vertex",
        options,
        report,
        remarked_origin(remarks),
        lambda: polygon_edges(counts, corners),
    )
    triangles = triangulate(counts, corners, positions, report)
    mesh = Mesh(vertices, triangles.faces, origin=origin)
    take_mesh_remark(path, mesh, remarks, report)
    used = _take_vertex_properties(path, mesh, vertex, remarks, report)
    reader = FaceReader(path, file, triangles, remarks, options, report)
    mesh = reader.take(mesh)
    _take_seams(file, mesh)
    mark_foreign_layers(mesh, remarks)
    _note_left_out(file, used, reader.used, report)
    return mesh


def _take_strips(path: PathLike, file: PlyFile, report: ImportReport) -> None:
    """Triangle strips become faces where there are no others."""
    face, strips = file.elements.get("face"), file.elements.get("tristrips")
    found = [name for name in CORNERS if strips is not None and name in strips.lists]
    if not found or face is not None and face.rows:
        return
    counts, corners = strips.lists[found[0]]
    corners = _whole(path, corners)
    # a -1 behind each strip
    separated = np.insert(corners.astype(np.int64), np.cumsum(counts), -1)
    faces = strip_triangles(separated)
    lists = {CORNERS[0]: (np.full(len(faces), 3, np.int64), faces.reshape(-1))}
    file.elements["face"] = Element("face", len(faces), lists=lists)
    del file.elements["tristrips"]
    left_out = [p.name for p in strips.properties if p.name != found[0]]
    if left_out:
        report.note("left out: properties of the triangle strips (%s)", ", ".join(left_out))


def _take_seams(file: PlyFile, mesh: Mesh) -> None:
    """Which vertices are copies along seams of textures, if our export says so."""
    name, key = SEAMS
    originals = file.elements[name].values.get(key) if name in file.elements else None
    if originals is None or originals.dtype.kind != "u" or mesh.seam_originals is not None:
        return
    if mesh.texture_coordinates is not None and copies_fault(mesh.vertices, originals) is None:
        mesh.seam_originals = originals.astype(np.uint32)
        del file.elements[name]


def _polygons(path, face, vertex_count):
    """(corners of each polygon (N,), the vertices of all corners)."""
    found = [name for name in CORNERS if face is not None and name in face.lists]
    if not found:
        raise MapFileError(
            "no_faces",
            path,
            "the PLY file has no faces (element face with a list vertex_indices)",
            "a map needs triangles: mesh_tool reconstruct makes them of clouds with poses",
        )
    counts, corners = face.lists[found[0]]
    corners = _whole(path, corners)
    check_corners(path, counts, corners, vertex_count)
    return counts, corners


def _whole(path, corners):
    """The numbers of vertices (N,) as whole numbers, also those of an ASCII file."""
    if corners.dtype.kind != "f":
        return corners
    wrong = np.flatnonzero(corners != np.floor(corners))
    if len(wrong):
        raise MapFileError(
            "index",
            path,
            "vertex index %s is no whole number" % corners[wrong[0]],
            "export the mesh again where it was made",
        )
    return corners.astype(np.int64)


def _take_vertex_properties(path, mesh, vertex, remarks, report):
    """Fill the mesh; returns the names of the properties that are done with."""
    types = {p.name: p.type for p in vertex.properties if not p.count}
    floats = {name for name in types if types[name][0] == "f"}
    used = set(POSITION)
    if set(NORMAL) <= floats:
        used |= set(NORMAL)
        mesh.vertex_normals = normals_or_none(columns(vertex, NORMAL), report)
    for names in COLORS:
        if mesh.vertex_colors is None and set(names) <= set(types):
            used |= set(names)
            kinds = {types[name] for name in names}
            mesh.vertex_colors = colors_or_none(columns(vertex, names), kinds, report)
    for names in TEXTURE:
        if mesh.texture_coordinates is None and set(names) <= floats:
            used |= set(names)
            mesh.texture_coordinates = coordinates_or_none(
                columns(vertex, names), mesh.faces, report
            )
    for remark in about(remarks, "vertex_attribute"):
        attribute = own_attribute(vertex, remark, types)
        if attribute is not None:
            used |= set(remark["properties"])
            name, parameters = remark["vertex_attribute"], parameters_of(remark)
            add_attribute(path, mesh, "vertex", name, attribute, report, parameters)
    named = {
        remark["property"]: remark
        for remark in about(remarks, "layer")
        if isinstance(remark.get("property"), str)
    }
    for name, values in vertex.values.items():
        remark = named.get(name)
        if name in used or remark is None and name in NO_LAYERS:
            continue
        used.add(name)
        if remark is None:
            add_layer(path, mesh, name, vertex.typed(name), report)
        else:
            add_layer(path, mesh, remark["layer"], values, report, parameters_of(remark))
    return used | _opaque_alpha(vertex)


def _opaque_alpha(vertex):
    """Names of the alpha property if it says nothing (all opaque)."""
    alpha = vertex.values.get("alpha")
    kinds = {p.type[0] for p in vertex.properties if p.name == "alpha"}
    opaque = alpha is not None and (alpha == (1.0 if "f" in kinds else 255)).all()
    return {"alpha"} if opaque else set()


def _note_left_out(file: PlyFile, of_vertices, of_faces, report):
    for name, used, whose in (("vertex", of_vertices, "vertices"), ("face", of_faces, "faces")):
        for p in file.elements[name].properties:
            if p.name not in used:
                kind = "list" if p.count else p.type
                report.note("left out: property %s of the %s (%s)", p.name, whose, kind)
    for element in file.elements.values():
        if element.name not in ("vertex", "face") and element.rows:
            report.note("left out: element %s (%d rows)", element.name, element.rows)
    if file.left_over:
        report.note("left out: %d values after the last element", file.left_over)
