"""Height differences: steps that a robot cannot climb."""

from mesh_map.base.parameter import Parameter
from mesh_map.layers.threshold_layer import RadiusLayer


class HeightDiffLayer(RadiusLayer):
    """Largest minus smallest height, in meters, over a vertex and those around it within a radius.

    One of the layers of Pütz et al., 4.2 and 5.3 (height differences).

    "Around" means: reached over edges through vertices whose Euclidean distance from the vertex is
    below the radius. The vertex itself counts; in the released mesh_map it did not, and a vertex
    without neighbors in reach had -inf.
    """

    PARAMETERS = (
        Parameter("threshold", 0.185, 0.05, 1.0, "lethal above, in meters", affects_costs=False),
        Parameter("radius", 0.3, 0.02, 1.0, "radius of the neighborhood in meters"),
    )
    STATISTIC = "height_difference"
