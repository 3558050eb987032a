"""A layer that is never finished."""

import time

import rospy

from strange_layers.layers import FlagLayer


class EndlessLayer(FlagLayer):
    """Takes as long as the node runs."""

    def compute(self, mesh_map, inputs):
        while not rospy.is_shutdown():
            time.sleep(0.02)
        return super().compute(mesh_map, inputs)
