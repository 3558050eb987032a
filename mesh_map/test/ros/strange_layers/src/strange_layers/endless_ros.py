"""A layer that is never finished."""

import os
import time

import rospy
from mesh_map.base.parameter import Parameter

from strange_layers.layers import FlagLayer


class EndlessLayer(FlagLayer):
    """Takes as long as the node runs; or longer, if it is deaf."""

    PARAMETERS = (*FlagLayer.PARAMETERS, Parameter("deaf", False))

    def compute(self, mesh_map, inputs):
        os.write(1, b"computing\n")
        while self.params["deaf"] or not rospy.is_shutdown():
            time.sleep(0.02)
        return super().compute(mesh_map, inputs)
