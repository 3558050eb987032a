"""Ridges: where the surface bends."""

from mesh_map.base.parameter import Parameter
from mesh_map.layers.threshold_layer import RadiusLayer


class RidgeLayer(RadiusLayer):
    """Mean distance, in meters, between the tips of the normals around a vertex and its own.

    As the RidgeLayer of the released mesh_map.

    The tip of a vertex is its position plus its normal of length 1. The mean is over the other
    vertices around (as of height differences) within a radius: on flat ground it is the mean
    distance of these, and larger where normals diverge. 0 where there are none; in the released
    mesh_map, such a vertex was lethal whatever the threshold.
    """

    PARAMETERS = (
        Parameter("threshold", 0.3, 0.01, 3.1415, "lethal above, in meters", affects_costs=False),
        Parameter("radius", 0.3, 0.01, 1.0, "radius of the neighborhood in meters"),
    )
    STATISTIC = "ridge"
