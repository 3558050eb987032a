"""Mesh to COLLADA 1.4.1 (ISO/PAS 17506), with textures beside it: meters, z up.

float32 is written with nine digits, from which it can be read again bit for bit. Vertices keep
their numbers and order; each material has its triangles.
"""
from typing import Iterator, List
from xml.sax.saxutils import quoteattr

import numpy as np

from mesh_msgs_hdf5 import __version__
from mesh_msgs_hdf5.formats.base.export_parts import Export, texture_files
from mesh_msgs_hdf5.formats.dae.own_materials import own_materials_extra
from mesh_msgs_hdf5.model.errors import PathLike
from mesh_msgs_hdf5.model.mesh import Mesh

_EXACT = "%.9g"
_BLOCK = 1 << 15
_TIME = "2000-01-01T00:00:00Z"  # the same mesh gives the same file


def dae_of(path: PathLike, mesh: Mesh) -> Export:
    """The DAE file and the textures."""
    export = Export()
    files = texture_files(path, mesh, export)
    count = 0 if mesh.materials is None else len(mesh.materials.colors)
    head = [
        '<?xml version="1.0" encoding="utf-8"?>',
        '<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">',
        "<asset><contributor><authoring_tool>mesh_msgs_hdf5 %s</authoring_tool></contributor>"
        "<created>%s</created><modified>%s</modified>" % (__version__, _TIME, _TIME),
        '<unit name="meter" meter="1"/><up_axis>Z_UP</up_axis></asset>',
    ]
    if files:
        head.append("<library_images>")
        for index, name in files.items():
            image = '<image id="image_%d"><init_from>%s</init_from></image>'
            head.append(image % (index, name))
        head.append("</library_images>")
    if count:
        head += ["<library_effects>", *_effects(mesh), "</library_effects>", "<library_materials>"]
        material = '<material id="material_%d"><instance_effect url="#effect_%d"/></material>'
        head += [material % (number, number) for number in range(count)]
        head.append("</library_materials>")
    bind = '<instance_material symbol="material_%d" target="#material_%d">'
    bind += '<bind_vertex_input semantic="UV" input_semantic="TEXCOORD" input_set="0"/>'
    binds = [bind % (n, n) + "</instance_material>" for n in range(count)]
    bound = ["<bind_material><technique_common>", *binds, "</technique_common></bind_material>"]
    tail = [
        "</mesh></geometry></library_geometries>",
        '<library_visual_scenes><visual_scene id="scene"><node id="node">',
        '<instance_geometry url="#mesh">',
        *(bound if count else []),
        "</instance_geometry></node></visual_scene></library_visual_scenes>",
        '<scene><instance_visual_scene url="#scene"/></scene>',
        *own_materials_extra(path, mesh, files),
        "</COLLADA>",
    ]
    head.append('<library_geometries><geometry id="mesh"><mesh>')
    body = b"".join([*_sources(mesh), *_triangles(mesh)])
    export.content = _lines(head) + body + _lines(tail)
    export.leave_out(
        *(mesh, "COLLADA", "vertex_costs", "vertex_attributes", "face_attributes", "labels"),
        *("features", "origin", "crs", "frame_id"),
    )
    return export


def _lines(texts: List[str]) -> bytes:
    return "".join(text + "\n" for text in texts).encode("utf-8")


def _effects(mesh: Mesh) -> Iterator[str]:
    materials = mesh.materials
    assert materials is not None
    for number, (color, index) in enumerate(zip(materials.colors, materials.texture_indices)):
        yield '<effect id="effect_%d"><profile_COMMON>' % number
        diffuse = "<color>%s 1</color>" % " ".join(_EXACT % level for level in color / 255.0)
        if index >= 0:
            yield '<newparam sid="surface"><surface type="2D">'
            yield "<init_from>image_%d</init_from>" % index
            yield '</surface></newparam><newparam sid="sampler"><sampler2D><source>surface</source>'
            yield "</sampler2D></newparam>"
            diffuse = '<texture texture="sampler" texcoord="UV"/>'
        yield '<technique sid="common"><lambert><diffuse>%s</diffuse>' % diffuse
        yield "</lambert></technique>"
        yield "</profile_COMMON></effect>"


def _sources(mesh: Mesh) -> Iterator[bytes]:
    yield _source("positions", mesh.vertices, "XYZ")
    if mesh.vertex_normals is not None:
        yield _source("normals", mesh.vertex_normals, "XYZ")
    if mesh.texture_coordinates is not None:
        yield _source("coordinates", mesh.texture_coordinates, "ST")
    if mesh.vertex_colors is not None:
        yield _source("colors", (mesh.vertex_colors / 255.0).astype(np.float32), "RGB")
    yield b'<vertices id="vertices"><input semantic="POSITION" source="#positions"/></vertices>\n'


def _source(name: str, values: np.ndarray, letters: str) -> bytes:
    rows, width = values.shape
    head = '<source id="%s"><float_array id="%s_array" count="%d">\n' % (name, name, rows * width)
    params = "".join('<param name="%s" type="float"/>' % letter for letter in letters)
    tail = '</float_array><technique_common><accessor source="#%s_array" count="%d" stride="%d">'
    tail = tail % (name, rows, width) + params + "</accessor></technique_common></source>\n"
    return head.encode() + _numbers(values, _EXACT) + tail.encode()


def _numbers(table: np.ndarray, form: str) -> bytes:
    pattern = " ".join([form] * table.shape[1]) + "\n"
    parts = []
    for start in range(0, len(table), _BLOCK):
        block = table[start : start + _BLOCK]
        parts.append((pattern * len(block) % tuple(block.reshape(-1).tolist())).encode("ascii"))
    return b"".join(parts)


def _triangles(mesh: Mesh) -> Iterator[bytes]:
    inputs = '<input semantic="VERTEX" source="#vertices" offset="0"/>'
    for name, semantic, values in (
        ("normals", "NORMAL", mesh.vertex_normals),
        ("coordinates", "TEXCOORD", mesh.texture_coordinates),
        ("colors", "COLOR", mesh.vertex_colors),
    ):
        if values is not None:
            more = ' set="0"' if semantic != "NORMAL" else ""
            inputs += '<input semantic="%s" source="#%s" offset="0"%s/>' % (semantic, name, more)
    groups = [("", mesh.faces)]
    if mesh.materials is not None:
        of_faces = mesh.materials.face_materials
        groups = [
            (" material=" + quoteattr("material_%d" % number), mesh.faces[of_faces == number])
            for number in np.unique(of_faces).tolist()
        ]
    for material, faces in groups:
        head = '<triangles count="%d"%s>%s<p>\n' % (len(faces), material, inputs)
        yield head.encode() + _numbers(faces, "%d") + b"</p></triangles>\n"
