"""glTF 2.0 (.glb, .gltf) to Mesh: in meters, z up (REP 103).

Vertices at the same position become one, as welded_mesh says; what our export wrote comes back as
it was.
"""
from typing import Any, Dict, List, Optional

import numpy as np
from mesh_msgs.split_mesh import copies_fault

from mesh_msgs_hdf5.formats.base.material_list import ImportedTextures, give_materials
from mesh_msgs_hdf5.formats.base.options import Options
from mesh_msgs_hdf5.formats.base.remarks import (
    NUMBERS,
    Remark,
    about,
    add_label,
    mark_foreign_layers,
    parameters_of,
    parsed_remarks,
    remarked_origin,
    take_mesh_remark,
)
from mesh_msgs_hdf5.formats.base.report import ImportReport
from mesh_msgs_hdf5.formats.base.scene import Scene, joined, unwelded_mesh, welded_mesh, z_up
from mesh_msgs_hdf5.formats.base.values import add_attribute
from mesh_msgs_hdf5.formats.gltf.gltf_file import GltfFile
from mesh_msgs_hdf5.formats.gltf.gltf_materials import GltfMaterialReader
from mesh_msgs_hdf5.formats.gltf.gltf_order import Order, kept_order
from mesh_msgs_hdf5.formats.gltf.gltf_scene import SceneReader, check_extensions
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike
from mesh_msgs_hdf5.model.mesh import Mesh


def read_gltf(path: PathLike, data: bytes, options: Options, report: ImportReport) -> Mesh:
    """A Mesh of the scene in a GLB file, or in glTF's JSON with its files beside it."""
    file = GltfFile(path, data)
    check_extensions(file)
    remarks = parsed_remarks(_remark_lines(file), report)
    own_names = _names_of_attributes(remarks)
    scene = joined(SceneReader(file, report, own_names).parts(), report)
    if not len(scene.faces):
        raise MapFileError(
            "no_faces",
            path,
            "the glTF file has no faces in its scene",
            "a map needs triangles: mesh the points first",
        )
    order = kept_order(remarks, scene.positions, scene.faces)
    scene.positions, scene.normals = z_up(scene.positions), z_up(scene.normals)
    own = [remark["vertices"] for remark in about(remarks, "vertices", int)]
    exact = own == [len(scene.positions)]
    scene.layers, parameters = _named_layers(scene.layers, remarks)
    scene.attributes = {
        own_names.get(name, name.lstrip("_") or "_"): values
        for name, values in scene.attributes.items()
    }
    if exact:
        if order.faces:
            _restore_order(file, scene, remarks)
        mesh = unwelded_mesh(path, scene, options, report, remarked_origin(remarks))
        take_mesh_remark(path, mesh, remarks, report)
    else:
        report.note("glTF's up axis was applied: z up")
        mesh = welded_mesh(path, scene, options, report)
    mesh.layer_parameters = {
        name: parameters[name] for name in mesh.vertex_costs if parameters.get(name)
    }
    useful = mesh.texture_coordinates is not None or exact
    textures = ImportedTextures(file.folder, report, wanted=useful)
    reader = GltfMaterialReader(file, remarks if exact else [], textures, report)
    materials, numbers = reader.chosen(scene.face_materials, keep_all=exact)
    give_materials(mesh, materials, numbers, textures, exact and bool(file.items("materials")))
    if exact:
        _take_values(file, mesh, remarks, order, report)
        if order.vertices:
            _take_seams(file, mesh, remarks)
    mark_foreign_layers(mesh, remarks if exact else [])
    return mesh


def _remark_lines(file: GltfFile) -> List[str]:
    extras = file.json["asset"].get("extras")
    lines = extras.get("mesh_tools") if isinstance(extras, dict) else None
    return [line for line in lines if isinstance(line, str)] if isinstance(lines, list) else []


def _names_of_attributes(remarks) -> Dict[str, str]:
    """glTF's attribute -> the name that the vertex attribute of our export is to have."""
    return {
        remark["attribute"]: remark["vertex_attribute"]
        for remark in about(remarks, "vertex_attribute")
        if isinstance(remark.get("attribute"), str)
    }


def _named_layers(layers, remarks):
    """(layers by the names that they are to have, parameters by name)."""
    named = {
        remark["attribute"]: remark
        for remark in about(remarks, "layer")
        if isinstance(remark.get("attribute"), str)
    }
    found, parameters = {}, {}
    for attribute, values in layers.items():
        remark = named.get(attribute, {})
        name = remark.get("layer", attribute.lstrip("_") or "_")
        for key, meaning in (("lethal", np.inf), ("unknown", np.nan)):
            if isinstance(remark.get(key), float):
                values = np.where(values == np.float32(remark[key]), np.float32(meaning), values)
        found[name] = values
        parameters[name] = parameters_of(remark)
    return found, parameters


def _restore_order(file: GltfFile, scene: Scene, remarks: List[Remark]) -> None:
    """Faces as they stood in the mesh that was exported: the file has them by material."""
    for remark in about(remarks, "face_order", int)[:1]:
        order = _array(file, remark["face_order"], "u4", len(scene.faces), 1)
        if order is None or not np.array_equal(np.sort(order[:, 0]), np.arange(len(order))):
            file.damaged("the order of the faces is none")
        place = np.zeros(len(order), np.int64)
        place[order[:, 0]] = np.arange(len(order))
        scene.faces, scene.face_materials = scene.faces[place], scene.face_materials[place]


def _still_fitting(remarks: List[Remark], order: Order, report: ImportReport) -> List[Remark]:
    """Those that are not about faces (or vertices) by numbers that they have no more."""
    gone = ["label", "face_attribute"] + ([] if order.vertices else ["vertex_attribute"])
    counts = {}
    for key in gone:
        lost = [
            remark for remark in about(remarks, key) if not isinstance(remark.get("attribute"), str)
        ]
        remarks = [remark for remark in remarks if all(remark is not each for each in lost)]
        counts[key] = len(lost)
    shown = ["%d %ss" % (n, key.replace("_", " ")) for key, n in counts.items() if n]
    report.note(
        "another program has changed the order of its faces%s: the order of the file is kept%s",
        "" if order.vertices else " or vertices",
        "; left out: %s, which belong to them by their number" % ", ".join(shown) if shown else "",
    )
    return remarks


def _array(file: GltfFile, view: Any, kind: Any, rows: int, width: Any) -> Optional[np.ndarray]:
    """(rows, width) numbers in a buffer view of our export, or None if it does not fit."""
    if kind not in NUMBERS or type(width) is not int or type(rows) is not int or width < 1:
        return None
    data = np.frombuffer(file.view(view), np.uint8)
    if len(data) != rows * width * np.dtype(kind).itemsize:
        return None
    return data.view("<" + kind).reshape(rows, width)


def _take_seams(file, mesh, remarks):
    """Which vertices are copies along seams of textures."""
    for remark in about(remarks, "seams", int)[:1]:
        data = np.frombuffer(file.view(remark["seams"]), np.uint8)
        originals = data[: len(data) // 4 * 4].view("<u4")
        useful = mesh.texture_coordinates is not None
        if useful and copies_fault(mesh.vertices, originals) is None:
            mesh.seam_originals = originals.astype(np.uint32)


def _take_values(file, mesh, remarks, order, report):
    damaged: Dict[str, int] = {}
    if not (order.faces and order.vertices):
        remarks = _still_fitting(remarks, order, report)
    for place, rows in (("vertex", len(mesh.vertices)), ("face", len(mesh.faces))):
        for remark in about(remarks, place + "_attribute"):
            name, parameters = remark[place + "_attribute"], parameters_of(remark)
            if isinstance(remark.get("attribute"), str):
                if parameters and name in mesh.vertex_attributes:
                    mesh.vertex_parameters[name] = parameters
                continue  # an attribute of glTF's
            values = _array(
                file, remark.get("view"), remark.get("type"), rows, remark.get("columns")
            )
            if values is None:
                what = place + " attributes"
                damaged[what] = damaged.get(what, 0) + 1
                continue
            values = values[:, 0] if remark.get("rank") == 1 else values
            add_attribute(file.path, mesh, place, name, values, report, parameters)
    for remark in about(remarks, "label"):
        count = remark.get("count")
        faces = (
            np.zeros((0, 1), np.uint32)
            if count == 0
            else _array(file, remark.get("view"), "u4", count, 1)
        )
        if faces is None or (faces >= len(mesh.faces)).any():
            damaged["labels"] = damaged.get("labels", 0) + 1
        else:
            add_label(file.path, mesh, remark, faces[:, 0], report)
    for what, number in damaged.items():
        report.note("left out: %d %s that are damaged", number, what)
