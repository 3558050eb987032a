"""Validation of geometry, colors, costs and vector fields."""

from typing import Any, List, Optional

import numpy as np

from mesh_msgs.checks.findings import (
    Finding,
    as_array,
    check_count,
    check_finite,
    check_indices,
    check_where,
    narrowed,
    stamped,
)

XYZ = ("x", "y", "z")
RGBA = ("r", "g", "b", "a")
_REMOVE = "remove or repair it where the mesh is made; `mesh_tool info FILE` lists faults of a file"


def check_geometry(
    vertices: Any, faces: Any, vertex_normals: Optional[Any] = None
) -> List[Finding]:
    """Faults of a mesh: degenerate faces, duplicates and holes are none.

    Args:
        vertices: (V, 3) floats, finite as float32.
        faces: (F, 3) integers, each a vertex.
        vertex_normals: (V, 3) floats, finite as float32, of any length; (0, 3) or None if unknown.
    Returns:
        Findings of array_shape, no_vertices, no_faces, vertex_not_finite, normal_count,
        normal_not_finite, face_index_out_of_range.
    """
    vertices, findings = as_array("vertices", vertices, 3, XYZ)
    faces, more = as_array("faces", faces, 3, ("vertex_indices",))
    findings += more
    if findings:
        return findings
    if not len(vertices):
        findings.append(Finding("no_vertices", "the mesh has no vertices", None, 1, "load a map"))
    if not len(faces):
        findings.append(Finding("no_faces", "the mesh has no faces", None, 1, "load a map"))
    findings += check_finite("vertex_not_finite", "vertex", vertices, _REMOVE)
    if vertex_normals is not None:
        findings += _check_normals(vertex_normals, len(vertices))
    target = "vertex/vertices"
    rule = "face_index_out_of_range"
    return findings + check_indices(rule, "face", target, faces, len(vertices), _REMOVE)


def _check_normals(vertex_normals: Any, vertex_count: int) -> List[Finding]:
    normals, findings = as_array("vertex_normals", vertex_normals, 3, XYZ)
    if findings or not len(normals):
        return findings
    hint = "send a normal for each vertex or none at all"
    findings += check_count(
        "normal_count", "vertex normals", len(normals), vertex_count, "vertices", hint
    )
    hint = "leave the normals out where they cannot be computed"
    return findings + check_finite("normal_not_finite", "vertex normal", normals, hint)


def check_costs(costs: Any, count: Optional[int], per: str) -> List[Finding]:
    """cost_count, cost_negative_infinity, cost_overflow; NaN (unknown) and +inf (lethal) are legal.

    Args:
        costs: (N,) floats.
        count: expected number, None if not known.
        per: what they belong to, "vertices" or "faces".
    """
    costs, findings = as_array("costs", costs, None)
    if findings:
        return findings
    hint = "send a value for each of the %s, NaN where it is unknown" % per
    findings += check_count("cost_count", "costs", len(costs), count, per, hint)
    single = narrowed(costs)
    infinite = np.isinf(single)
    if not infinite.any():
        return findings
    given = np.isinf(costs)
    findings += check_where(
        "cost_negative_infinity",
        "cost",
        costs,
        given & (single < 0),
        "which has no meaning",
        "send NaN for unknown, +inf for lethal",
    )
    return findings + check_where(
        "cost_overflow",
        "cost",
        costs,
        infinite & ~given,
        "which does not fit into float32",
        "scale the layer, or send +inf for lethal",
    )


def check_colors(colors: Any, count: Optional[int], per: str) -> List[Finding]:
    """color_count, color_not_finite, color_out_of_range.

    Args:
        colors: (N, 4) red, green, blue, alpha, 0 to 1 each.
        count: expected number, None if not known.
        per: what they belong to, "vertices", "faces" or "materials".
    """
    colors, findings = as_array("colors", colors, 4, RGBA)
    if findings:
        return findings
    hint = "send a color for each of the %s" % per
    findings += check_count("color_count", "colors", len(colors), count, per, hint)
    if not len(colors):
        return findings
    single = narrowed(colors)
    # One pass tells that all is well; NaN fails both comparisons.
    if single.min() >= 0 and single.max() <= 1:
        return findings
    hint = "send numbers from 0 to 1; divide bytes by 255"
    findings += check_finite("color_not_finite", "color", colors, hint)
    outside = np.isfinite(single) & ((single < 0) | (single > 1))
    reason = "which is not between 0 and 1"
    return findings + check_where(
        "color_out_of_range", "color", colors, outside.any(axis=1), reason, hint
    )


def mesh_triangle_indices(msg: Any, vertex_count: Optional[int] = None) -> List[Finding]:
    """A single face."""
    faces, findings = as_array("vertex_indices", [list(msg.vertex_indices)], 3)
    rule = "face_index_out_of_range"
    target = "vertex/vertices"
    return findings + check_indices(rule, "face", target, faces, vertex_count, _REMOVE)


def mesh_geometry(msg: Any) -> List[Finding]:
    """See check_geometry."""
    return check_geometry(msg.vertices, msg.faces, msg.vertex_normals)


mesh_geometry_stamped = stamped("mesh_geometry", mesh_geometry)


def mesh_vertex_colors(msg: Any, vertex_count: Optional[int] = None) -> List[Finding]:
    """See check_colors."""
    return check_colors(msg.vertex_colors, vertex_count, "vertices")


mesh_vertex_colors_stamped = stamped("mesh_vertex_colors", mesh_vertex_colors)


def mesh_vertex_costs(msg: Any, vertex_count: Optional[int] = None) -> List[Finding]:
    """See check_costs."""
    return check_costs(msg.costs, vertex_count, "vertices")


mesh_vertex_costs_stamped = stamped("mesh_vertex_costs", mesh_vertex_costs)


def mesh_face_costs(msg: Any, face_count: Optional[int] = None) -> List[Finding]:
    """See check_costs."""
    return check_costs(msg.costs, face_count, "faces")


mesh_face_costs_stamped = stamped("mesh_face_costs", mesh_face_costs)
