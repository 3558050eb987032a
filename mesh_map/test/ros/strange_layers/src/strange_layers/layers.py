"""A layer that gets its data from a topic, and layers with faults."""

import ctypes
import os

import numpy as np
from mesh_map.base.errors import MeshMapError
from mesh_map.base.parameter import Parameter
from mesh_map.costs.layer import Layer


class FlagLayer(Layer):
    """One vertex has a cost, and so much of it, as a topic says; vectors there point up."""

    PARAMETERS = (
        Parameter("height", 2.0, 0.0, None, "of the flag"),
        Parameter("fabric", "silk", choices=("silk", "wool")),
        Parameter("arrows", True),
        Parameter("colors", ("red",)),
    )
    ROS_ADAPTER = "strange_layers.adapters_ros.FlagAdapter"

    flag = (0, 0.0)

    def compute(self, mesh_map, inputs):
        if self.params["height"] == 13.0:
            raise MeshMapError("no flag is 13 m high")
        costs = np.zeros(len(mesh_map.vertices), np.float32)
        costs[self.flag[0]] = self.flag[1] * self.params["height"]
        vectors = np.zeros((len(costs), 3), np.float32)
        vectors[self.flag[0], 2] = 1
        return (costs, costs > 9, vectors) if self.params["arrows"] else (costs, costs > 9)


class DeafLayer(FlagLayer):
    """Its adapter fails."""

    ROS_ADAPTER = "strange_layers.adapters_ros.Broken"


class OddLayer(FlagLayer):
    """What it names is no adapter."""

    ROS_ADAPTER = "strange_layers.layers.FlagLayer"


class GiantLayer(FlagLayer):
    """dynamic_reconfigure has no numbers of this size."""

    PARAMETERS = FlagLayer.PARAMETERS + (Parameter("size", 2**40),)


class NativeLayer(Layer):
    """Native code that never ends, and keeps Python's lock."""

    def compute(self, mesh_map, inputs):
        os.write(1, b"computing\n")
        return ctypes.PyDLL(None).sleep(100_000)
