"""Layers that tests steer."""

import os
import time

import numpy as np

from mesh_map.base.parameter import Parameter
from mesh_map.costs.layer import Layer, LayerResult


class PatientLayer(Layer):
    """Waits for a file, so that a test says when the map is ready. One vertex is lethal."""

    PARAMETERS = (Parameter("file", ""), Parameter("lethal_vertex", 0, 0))

    def compute(self, mesh_map, inputs):
        while not os.path.exists(self.params["file"]):
            time.sleep(0.01)
        lethal = np.array([self.params["lethal_vertex"]])
        return LayerResult(np.zeros(len(mesh_map.vertices), np.float32), lethal)


class FussyLayer(Layer):
    """Fails where a cost that it reads is above 5. Nothing is lethal."""

    READS_LAYERS = True

    def compute(self, mesh_map, inputs):
        largest = max(read.costs.max() for read in inputs.values())
        if largest > 5:
            raise RuntimeError("%g is too much" % largest)
        return LayerResult(np.zeros(len(mesh_map.vertices), np.float32), np.zeros(0, np.int64))
