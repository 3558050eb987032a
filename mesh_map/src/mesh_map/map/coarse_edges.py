"""Whether faces are so large that layers and planners know little of what is in them."""

import math
from typing import Dict, Mapping

import numpy as np

from mesh_map.costs.layer import Layer
from mesh_map.map.mesh_map import MeshMap

# Of the surface: some long edges, as at the rim of a scan, are no reason to say anything.
_SHARE = 0.05
_STEEP = math.cos(math.radians(45.0))  # of the angle between a face's normal and up
_AT_ONCE = 100_000  # faces that are looked at together: maps have very many


def coarse_remark(mesh_map: MeshMap, radii: Mapping[str, float] = {}) -> str:
    """Says, for people, that edges are longer than a radius, and the way out; else it is empty.

    Costs are those of vertices: what is lethal in the middle of a large face closes all of it, and
    an inflation without vertices within its radius inflates nothing. Edges count as longer where
    more than a twentieth of the surface is in faces with one that is. The length that is named is
    half of the radius: what stands on a floor is known to half an edge, and with it no path comes
    nearer to that than 9/10 of the radius (measured: README of mesh_map).

    Steep faces that rise by more than the radius are said however few they are, unless a layer
    sees them: of such a step both ends may be level, and too far from each other for others.

    Args:
        mesh_map: with its layers; their parameters that are called a radius count, if enabled.
        radii: more of them: what it is of -> meters; 0 for none.
    """
    enabled = {name: y for name, y in mesh_map.layers.items() if y.params.get("enabled", True)}
    known = {**_layer_radii(enabled), **{what: r for what, r in radii.items() if r > 0.0}}
    seen = any(layer.sees_steps() for layer in enabled.values())
    if not known:
        return ""
    what, radius = min(known.items(), key=lambda item: item[1])
    whole = large = longest = highest = 0.0
    steep = 0
    for begin in range(0, len(mesh_map.faces), _AT_ONCE):
        corners = mesh_map.vertices[mesh_map.faces[begin : begin + _AT_ONCE]]
        u, v = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
        uu, vv, uv, ww = (
            np.einsum("ij,ij->i", p, q) for p, q in ((u, u), (v, v), (u, v), (v - u, v - u))
        )
        squared = np.maximum(np.maximum(uu, vv), ww)
        areas = np.sqrt(np.maximum(uu * vv - uv * uv, 0.0))  # twice that of each
        whole += float(areas.sum(dtype=np.float64))
        is_long = squared > radius * radius
        large += float(areas[is_long].sum(dtype=np.float64))
        if not seen:
            rises = _steep_rises(corners[is_long], mesh_map.geometry.up)
            steep += np.count_nonzero(rises > radius)
            highest = max(highest, float(rises.max(initial=0.0)))
        longest = max(longest, math.sqrt(float(squared.max())))
    share, found = large / whole if whole else 0.0, []
    if share > _SHARE:
        found.append(
            "%.0f %% of the surface is in faces with edges longer than %s, %.3g m (the longest has "
            "%.3g m): layers and planners know costs at vertices only, so obstacles and paths are "
            "as coarse as that, and walls may be nearer by half an edge"
            % (100 * share, what, radius, longest)
        )
    if steep:
        found.append(
            "%d faces steeper than 45 degrees rise by more than %s, %.3g m, without a vertex "
            "between (up to %.3g m): layers may not see such steps and walls at all"
            % (steep, what, radius, highest)
        )
    if not found:
        return ""
    way_out = (
        " (max_edge_length: %.2g, half of the radius, makes the edges of the map short enough; "
        "%.2g where no passage is narrow)" % (0.5 * radius, radius)
    )
    return "; ".join(found) + way_out


def _steep_rises(corners: np.ndarray, up: np.ndarray) -> np.ndarray:
    """How much faces (K,3,3) that are steep rise along up (m); 0 of others, and without area."""
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    heights = corners @ np.asarray(up, corners.dtype)
    upward = np.abs(normals @ np.asarray(up, normals.dtype))
    steep = upward < _STEEP * np.linalg.norm(normals, axis=1)
    return np.where(steep, np.ptp(heights, axis=1), 0.0)


def _layer_radii(layers: Mapping[str, Layer]) -> Dict[str, float]:
    found = {}
    for name, layer in layers.items():
        for parameter, value in layer.params.items():
            if parameter.endswith("radius") and isinstance(value, float) and value > 0.0:
                found["%s of layer %s" % (parameter, name)] = value
    return found
