"""Costs from labels of faces: forbidden areas, kinds of ground, preferred ways."""

import logging
import math
from typing import Any, Dict, List

import numpy as np
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.label_names import split_label

from mesh_map.base.errors import MeshMapError
from mesh_map.base.parameter import Parameter
from mesh_map.costs.layer import Inputs, Layer, LayerResult
from mesh_map.layers.file_layer import contents_of
from mesh_map.map.mesh_map import MeshMap

_LOG = logging.getLogger("mesh_map")
_FEW = 2  # labels that are read one by one; more at once


class LabelLayer(Layer):
    """Faces of chosen labels are lethal, have a cost, or are preferred to all others.

    Labels are named by their class, which means all labels of it, or by their whole text: tree, or
    tree_1. A vertex is lethal if a face around it is. Else it has the largest cost of those around
    it that have one, else 0 if one of them is preferred. Where nothing is said of any of them, it
    costs 0, or other_cost if there are preferred labels.

    Labels are read from the map file, edits that are only in its journal included, whenever the
    layer is evaluated; in a node that is soon after labels have changed.

    Attributes:
        labels_version: MapContents.labels_version() at that time; None before.
    """

    PARAMETERS = (
        Parameter("lethal", (), description="labels of which all faces are lethal"),
        Parameter("costs", {}, description="label: cost of its faces"),
        Parameter("preferred", (), description="labels whose faces cost 0, and others other_cost"),
        Parameter("other_cost", 0.5, 0.0, None, "of what is not labeled, if there are preferred"),
    )
    STORABLE = False  # reading the labels is needed anyway, and takes longer than the rest
    ROS_ADAPTER = "mesh_map.ros.labels_watch.LabelWatcher"
    labels_version: Any = None

    def compute(self, mesh_map: MeshMap, inputs: Inputs) -> LayerResult:
        prices = self._prices()
        names = list(self._names("lethal")) + list(prices) + list(self._names("preferred"))
        contents = contents_of(mesh_map)
        try:
            self.labels_version = contents.labels_version()
            faces = self._faces(contents, names)
        except MapFileError as error:
            raise MeshMapError(str(error)) from error
        costs = np.zeros(len(mesh_map.vertices))
        if self.params["preferred"]:
            costs[:] = self.params["other_cost"]

        def pay(name: str, price: float) -> None:
            for some in faces[name]:
                costs[mesh_map.faces[some]] = price

        for name in self._names("preferred"):
            pay(name, 0.0)
        for name in sorted(prices, key=lambda name: prices[name]):
            pay(name, prices[name])
        for name in self._names("lethal"):
            pay(name, math.inf)
        with np.errstate(over="ignore"):  # what does not fit is lethal
            costs = costs.astype(np.float32)
        return LayerResult(costs, np.isposinf(costs))

    def _names(self, parameter: str) -> List[str]:
        names = list(self.params[parameter])
        for name in names:
            if not isinstance(name, str) or not name:
                raise MeshMapError("%s has %r, but it has to name labels" % (parameter, name))
        return names

    def _prices(self) -> Dict[str, float]:
        prices: Dict[str, float] = {}
        for name, price in self.params["costs"].items():
            number = isinstance(price, (int, float)) and not isinstance(price, bool)
            if not isinstance(name, str) or not name or not (number and price >= 0):
                raise MeshMapError(
                    "costs has %r: %r" % (name, price), "label: cost, 0 or more, .inf for lethal"
                )
            prices[name] = float(price)
        return prices

    def _faces(self, contents: Any, names: List[str]) -> Dict[str, List[np.ndarray]]:
        """Name -> faces of each label that it stands for."""
        texts = contents.label_names()
        meant = {
            name: [text for text in texts if name in (text, split_label(text)[0])] for name in names
        }
        wanted = {text for some in meant.values() for text in some}
        if len(wanted) > _FEW:
            labels = contents.labels()
        else:
            labels = {text: contents.label(text) for text in wanted}
        found = {name: [labels[text].faces for text in some] for name, some in meant.items()}
        missing = sorted(name for name in found if not found[name])
        if missing:
            known = sorted({split_label(text)[0] for text in texts})
            shown = ", ".join(known[:20]) + (", ..." if len(known) > 20 else "")
            _LOG.warning(
                "layer %s: the map has no labels %s (classes: %s)",
                self.name,
                ", ".join(missing),
                shown or "none",
            )
        return found
