"""Validation of vector fields, features and the all-in-one mesh of release 1.0."""

from typing import Any, List, Optional

import numpy as np

from mesh_msgs.checks.clusters import check_clusters, check_image, check_materials
from mesh_msgs.checks.findings import (
    Finding,
    as_array,
    check_count,
    check_finite,
    check_indices,
    check_uuid,
    each,
    stamped,
)
from mesh_msgs.checks.geometry import XYZ, check_colors, check_geometry


def vector_field(msg: Any) -> List[Finding]:
    """vector_count, position_not_finite, vector_not_finite."""
    positions, findings = as_array("positions", msg.positions, 3, XYZ)
    vectors, more = as_array("vectors", msg.vectors, 3, XYZ)
    findings += more
    if findings:
        return findings
    hint = "send a vector for each position"
    findings += check_count(
        "vector_count", "vectors", len(vectors), len(positions), "positions", hint
    )
    hint = "leave out positions without a direction"
    findings += check_finite("position_not_finite", "position", positions, hint)
    return findings + check_finite("vector_not_finite", "vector", vectors, hint)


vector_field_stamped = stamped("vector_field", vector_field)


def feature(msg: Any) -> List[Finding]:
    """feature_not_finite, descriptor_not_finite."""
    hint = "leave the feature out"
    location = np.array([[getattr(msg.location, name) for name in XYZ]], dtype=float)
    findings = check_finite("feature_not_finite", "location", location, hint)
    descriptor = np.array([number.data for number in msg.descriptor], dtype=float)
    return findings + check_finite("descriptor_not_finite", "descriptor number", descriptor, hint)


def mesh_features(msg: Any, uuid: Optional[str] = None) -> List[Finding]:
    """See feature; descriptor_length (all are as long as the first one), uuid_mismatch."""
    findings = each("feature", msg.features, feature)
    lengths = np.array([len(item.descriptor) for item in msg.features], dtype=int)
    other = lengths != lengths[0] if len(lengths) else lengths
    if other.any():
        first = int(np.argmax(other))
        what = "the descriptor of feature %d has %d numbers, that of the first one %d (%d in all)"
        what = what % (first, lengths[first], lengths[0], np.count_nonzero(other))
        hint = "send features of one kind"
        count = int(np.count_nonzero(other))
        findings.append(Finding("descriptor_length", what, first, count, hint))
    return findings + check_uuid(msg.map_uuid, uuid)


def triangle_mesh(msg: Any) -> List[Finding]:
    """See check_geometry, check_colors, mesh_face_cluster, mesh_material, check_image.

    Also texture_coordinate_count, texture_coordinate_not_finite, cluster_material_count and
    texture_index_out_of_range.
    """
    vertex_count, face_count = len(msg.vertices), len(msg.triangles)
    findings = check_geometry(msg.vertices, msg.triangles, msg.vertex_normals)
    if len(msg.vertex_colors):
        findings += check_colors(msg.vertex_colors, vertex_count, "vertices")
    if len(msg.triangle_colors):
        findings += check_colors(msg.triangle_colors, face_count, "faces")
    coords, more = as_array("vertex_texture_coords", msg.vertex_texture_coords, 3, XYZ)
    findings += more
    if len(coords):
        rule, noun = "texture_coordinate_count", "texture coordinates"
        hint = "send one for each vertex or none at all"
        findings += check_count(rule, noun, len(coords), vertex_count, "vertices", hint)
        rule, noun = "texture_coordinate_not_finite", "texture coordinate"
        findings += check_finite(rule, noun, coords, "send 0 where there is no texture")
    if len(msg.clusters):
        rule, hint = "cluster_material_count", "send a material for each cluster"
        count = len(msg.face_materials)
        findings += check_count(rule, "materials", count, len(msg.clusters), "clusters", hint)
    findings += check_clusters(msg.clusters, face_count)
    findings += check_materials(msg.face_materials)
    return findings + _check_textures(msg)


def _check_textures(msg: Any) -> List[Finding]:
    used = [m.texture_index for m in msg.face_materials if m.has_texture]
    indices, _ = as_array("texture_index", used, None)
    rule, hint = "texture_index_out_of_range", "send every texture that a material uses"
    findings = check_indices(rule, "material", "texture/textures", indices, len(msg.textures), hint)
    return findings + each("texture", msg.textures, check_image)


triangle_mesh_stamped = stamped("mesh", triangle_mesh)
