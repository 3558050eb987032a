"""Validation of sparse costs, clusters, labels, materials and textures."""

from typing import Any, List, Optional

import numpy as np

from mesh_msgs.checks.findings import (
    Finding,
    as_array,
    check_count,
    check_finite,
    check_indices,
    check_uuid,
    each,
    shown,
    stamped,
)
from mesh_msgs.checks.geometry import RGBA, check_colors, check_costs
from mesh_msgs.checks.label_name import MAX_LABEL_BYTES, label_fault

# Bytes per pixel of the encodings of sensor_msgs/Image that a texture may have.
_ENCODINGS = {"rgb8": 3, "bgr8": 3, "rgba8": 4, "bgra8": 4, "mono8": 1, "8UC1": 1, "8UC3": 3}
_ENCODINGS.update({"8UC4": 4, "mono16": 2, "16UC1": 2, "rgb16": 6, "rgba16": 8})

_NO_LABEL = Finding("label_empty", "there is no text", None, 1, "choose one such as 'tree_1'")


def mesh_vertex_costs_sparse(msg: Any, vertex_count: Optional[int] = None) -> List[Finding]:
    """See check_costs; also vertex_index_out_of_range. There are as many costs as vertices."""
    vertices, findings = as_array("vertices", msg.vertices, None)
    if findings:
        return findings
    hint = "name vertices of the mesh that the UUID stands for"
    findings = check_costs(msg.costs, len(vertices), "vertices")
    for value in check_costs([msg.default_value], None, "vertices"):
        what = "default_value is %g" % msg.default_value
        findings.append(value._replace(what=what, index=None))
    rule, noun = "vertex_index_out_of_range", "entry"
    return findings + check_indices(rule, noun, "vertex/vertices", vertices, vertex_count, hint)


mesh_vertex_costs_sparse_stamped = stamped("mesh_vertex_costs", mesh_vertex_costs_sparse)


def mesh_face_cluster(msg: Any, face_count: Optional[int] = None) -> List[Finding]:
    """cluster_face_out_of_range, label_unusable; an empty label is none."""
    faces, findings = as_array("face_indices", msg.face_indices, None)
    hint = "label faces of the mesh that the UUID stands for"
    rule, noun = "cluster_face_out_of_range", "entry"
    findings += check_indices(rule, noun, "face/faces", faces, face_count, hint)
    return findings + _check_label(msg.label)


def _check_label(label: str) -> List[Finding]:
    fault = label_fault(label)
    if fault is None:
        return []
    what = "the label %s %s" % (shown(label), fault.what)
    hint = "choose up to %d bytes without '/', such as 'tree_1'" % MAX_LABEL_BYTES
    return [Finding("label_unusable", what, fault.index, 1, hint)]


def _labeled_cluster(msg: Any, face_count: Optional[int] = None) -> List[Finding]:
    """See mesh_face_cluster; label_empty."""
    findings = mesh_face_cluster(msg, face_count)
    if not msg.label:
        findings.append(_NO_LABEL._replace(what="the cluster has no label"))
    return findings


mesh_face_cluster_stamped = stamped("cluster", _labeled_cluster)


def mesh_label_colors(msg: Any, uuid: Optional[str] = None) -> List[Finding]:
    """See check_colors; label_empty, label_unusable, uuid_mismatch."""
    rows = [[getattr(color, name) for name in RGBA] for color in msg.colors]
    findings = check_colors(np.array(rows, float).reshape(-1, 4), len(msg.labels), "labels")
    findings += each("label", msg.labels, lambda text: _check_label(text) if text else [_NO_LABEL])
    return findings + check_uuid(msg.uuid, uuid)


def mesh_material(msg: Any) -> List[Finding]:
    """See check_colors."""
    return check_materials([msg])


def check_materials(materials: Any) -> List[Finding]:
    """Colors of a list of MeshMaterial; see check_colors."""
    rows = [[getattr(m.color, name) for name in RGBA] for m in materials]
    return check_colors(rows, None, "materials") if rows else []


def mesh_vertex_tex_coords(msg: Any) -> List[Finding]:
    """texture_coordinate_not_finite."""
    return _check_tex_coords([[msg.u, msg.v]], None)


def _check_tex_coords(tex_coords: Any, vertex_count: Optional[int]) -> List[Finding]:
    coords, findings = as_array("vertex_tex_coords", tex_coords, 2, ("u", "v"))
    if findings or not len(coords):
        return findings
    hint = "send a pair for each vertex or none at all"
    rule, noun = "texture_coordinate_count", "texture coordinates"
    findings += check_count(rule, noun, len(coords), vertex_count, "vertices", hint)
    rule, noun = "texture_coordinate_not_finite", "texture coordinate"
    return findings + check_finite(rule, noun, coords, "send 0 where there is no texture")


def mesh_materials(
    msg: Any, vertex_count: Optional[int] = None, face_count: Optional[int] = None
) -> List[Finding]:
    """See check_colors, mesh_vertex_tex_coords, mesh_face_cluster.

    Also cluster_material_count, material_index_out_of_range, texture_coordinate_count.
    """
    findings = check_clusters(msg.clusters, face_count)
    indices, more = as_array("cluster_materials", msg.cluster_materials, None)
    findings += more
    hint = "send the index of a material for each cluster"
    rule, noun = "cluster_material_count", "cluster_materials"
    findings += check_count(rule, noun, len(indices), len(msg.clusters), "clusters", hint)
    rule, target = "material_index_out_of_range", "material/materials"
    findings += check_indices(rule, "cluster", target, indices, len(msg.materials), hint)
    findings += check_materials(msg.materials)
    return findings + _check_tex_coords(msg.vertex_tex_coords, vertex_count)


def check_clusters(clusters: Any, face_count: Optional[int]) -> List[Finding]:
    """The findings of mesh_face_cluster for a list, preceded by the number of the cluster."""
    findings = []
    for number, cluster in enumerate(clusters):
        for finding in mesh_face_cluster(cluster, face_count):
            findings.append(finding._replace(what="cluster %d: %s" % (number, finding.what)))
    return findings


mesh_materials_stamped = stamped("mesh_materials", mesh_materials)


def mesh_texture(msg: Any, uuid: Optional[str] = None) -> List[Finding]:
    """See check_image; uuid_mismatch."""
    return check_image(msg.image) + check_uuid(msg.uuid, uuid)


def check_image(image: Any) -> List[Finding]:
    """image_encoding, image_empty, image_size: the data holds `height` rows of `step` bytes."""
    if image.encoding not in _ENCODINGS:
        what = "the texture has the encoding %s" % shown(image.encoding)
        return [Finding("image_encoding", what, None, 1, "use one of %s" % ", ".join(_ENCODINGS))]
    size = "%d x %d pixels" % (image.width, image.height)
    if not image.width or not image.height:
        what = "the texture has %s" % size
        return [Finding("image_empty", what, None, 1, "leave the texture out")]
    row = image.width * _ENCODINGS[image.encoding]
    given = len(image.data)
    if image.step >= row and given >= image.step * image.height:
        return []
    what = "a texture of %s in %s has a step of %d and %d bytes"
    what = what % (size, image.encoding, image.step, given)
    return [Finding("image_size", what, None, 1, "send %d bytes for each row" % row)]
