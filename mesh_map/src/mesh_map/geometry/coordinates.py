"""Coordinates far from zero, such as those of a UTM zone, in float32: near an origin."""

from typing import Any, Sequence

import numpy as np
from mesh_msgs.checks.rounding import is_too_much, suggested_origin

from mesh_map.base.errors import MeshMapError


def checked_origin(origin: Any) -> np.ndarray:
    """(3,) float64, meters.

    Raises:
        MeshMapError: anything but three finite numbers.
    """
    try:
        found = np.array(origin, np.float64)
    except (TypeError, ValueError):
        found = np.array(np.nan)
    if found.shape != (3,) or not np.isfinite(found).all():
        raise MeshMapError("origin is %r, but it has to be x, y, z in meters" % (origin,))
    return found


def check_rounding(
    what: str, lost: float, vertices: np.ndarray, origin: Sequence[float] = (0.0, 0.0, 0.0)
) -> None:
    """Refuses coordinates that rounding to float32 has changed too much.

    Args:
        what: cannot be used, for the error.
        lost: by how much a coordinate has changed at most, meters.
        vertices: (V, 3) float32, as they are after rounding.
        origin: (3,) meters, that was subtracted from them before.
    Raises:
        MeshMapError: with an origin that helps.
    """
    if is_too_much(lost, vertices):
        raise MeshMapError(
            "%s: float32 would change its coordinates by up to %.3g m" % (what, lost),
            "give an origin near to it, such as [%s]: it is subtracted before they are rounded"
            % suggested_origin(vertices, origin),
        )
