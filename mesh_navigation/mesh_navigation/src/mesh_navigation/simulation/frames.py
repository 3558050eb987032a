"""The frames of a robot: where odometry has to be seen from, so that it ends at the truth."""

import numpy as np

from mesh_navigation.pose import Pose, multiply, rotate


def inverted(pose: Pose) -> Pose:
    """The parent's pose in the child, of a child's pose (unit quaternion) in the parent."""
    back = pose.orientation * np.array([-1.0, -1.0, -1.0, 1.0])
    return Pose(-rotate(back, pose.position), back)


def combined(first: Pose, second: Pose) -> Pose:
    """The pose in the grandparent of a ``second`` that is given in the frame of the ``first``."""
    return Pose(
        first.position + rotate(first.orientation, second.position),
        multiply(first.orientation, second.orientation),
    )


def odometry_origin(truth: Pose, odometry: Pose) -> Pose:
    """The pose of the odometry's frame in the map, so that ``odometry`` in it is the ``truth``."""
    return combined(truth, inverted(odometry))
