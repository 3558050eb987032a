"""The points of a sensor_msgs/PointCloud2 as an array."""

from typing import Any

import numpy as np
from mesh_msgs import point_cloud

from mesh_map.base.errors import MeshMapError


def cloud_points(message: Any) -> np.ndarray:
    """As `mesh_msgs.point_cloud.cloud_points`.

    Raises:
        MeshMapError: in place of PointCloudError.
    """
    try:
        return point_cloud.cloud_points(message)
    except point_cloud.PointCloudError as error:
        raise MeshMapError(str(error)) from error
