"""The potential that a plan was made from, so that a controller can follow it."""

from typing import NamedTuple, Optional

import numpy as np


class PlanField(NamedTuple):
    """Costs to the goal of one plan, which never change; what `mesh_map.surface_path.FieldTracer`
    takes as a field."""

    labels: np.ndarray
    """(V,) float64, read-only: the cost from each vertex to the goal; above ``limit`` not final."""
    limit: float
    slowness: Optional[np.ndarray]
    """(V,) float32, what a meter costs there, not finite where it is closed; None: 1 everywhere."""
    goal_face: int
    goal_position: np.ndarray
    """(3,) m."""
