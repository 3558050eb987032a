"""Roughness: ground that shakes a robot."""

from mesh_map.base.parameter import Parameter
from mesh_map.layers.threshold_layer import RadiusLayer


class RoughnessLayer(RadiusLayer):
    """How much the normals of neighbors differ, in radians, around each vertex within a radius.

    One of the layers of Pütz et al., 4.2 and 5.3 (roughness).

    The mean, over a vertex and those around it (as of height differences), of the mean angle
    between the normal of a vertex and those of its neighbors. In the released mesh_map, the vertex
    itself did not count, and a non-manifold vertex had the angle pi, whatever is around it.
    """

    PARAMETERS = (
        Parameter("threshold", 0.3, 0.01, 3.1415, "lethal above, in radians", affects_costs=False),
        Parameter("radius", 0.3, 0.02, 1.0, "radius of the neighborhood in meters"),
    )
    STATISTIC = "roughness"
