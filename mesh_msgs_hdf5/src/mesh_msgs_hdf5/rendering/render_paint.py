"""The colors of a mesh in a picture: of a layer, of labels, of textures, ...

A paint knows the color of points on the surface, each given by its face and the weights of the
face's corners, and the legend that explains it.
"""
from typing import List, NamedTuple, Optional, Tuple

import numpy as np

from mesh_msgs_hdf5.model.label_names import split_label
from mesh_msgs_hdf5.model.layer_meaning import LayerMeaning
from mesh_msgs_hdf5.model.mesh import Mesh
from mesh_msgs_hdf5.rendering.render_scale import (
    LETHAL,
    RAINBOW,
    UNKNOWN,
    finite_limits,
    scale_colors,
    value_colors,
)

PLAIN = (0.75, 0.75, 0.75)  # of what has no color of its own


class Legend(NamedTuple):
    """title: what the colors mean; limits, stops: of a color bar, or None; entries: (text, color)
    of single colors; beyond: values below and above the limits were painted as the limits.
    """

    title: str
    limits: Optional[Tuple[float, float]] = None
    stops: Optional[np.ndarray] = None
    entries: Tuple[Tuple[str, Tuple[float, ...]], ...] = ()
    beyond: Tuple[bool, bool] = (False, False)


class VertexValues:
    """Values (V,) of vertices: between them they change evenly; a point next to a vertex whose
    value is not finite shows that."""

    def __init__(self, title, faces, values, stops=RAINBOW, limits=None):
        self._faces, self._values, self._stops = faces, values, stops
        self._limits = finite_limits(values) if limits is None else limits
        self.legend = _value_legend(title, values, stops, self._limits)

    def colors(self, face: np.ndarray, weights: np.ndarray) -> np.ndarray:
        """(N, 3) of points on the faces (N,) where the corners have the weights (N, 3)."""
        values = self._values[self._faces[face]].astype(np.float64)
        finite = np.isfinite(values)
        share = np.where(finite, weights, 0)
        total = _row_sums(share)
        mixed = _row_sums(np.where(finite, values, 0) * share) / np.where(total > 0, total, 1)
        nearest = np.take_along_axis(values, weights.argmax(axis=1)[:, None], axis=1)[:, 0]
        return value_colors(
            self._stops, self._limits, np.where(np.isfinite(nearest), mixed, nearest)
        )


def _row_sums(rows):
    """Of (N, 3), which NumPy's own sum is slow at."""
    return rows[:, 0] + rows[:, 1] + rows[:, 2]


class FaceValues:
    """Values (F,) of faces."""

    def __init__(self, title, values, stops=RAINBOW, limits=None):
        self._values, self._stops = values, stops
        self._limits = finite_limits(values) if limits is None else limits
        self.legend = _value_legend(title, values, stops, self._limits)

    def colors(self, face, weights):
        return value_colors(self._stops, self._limits, self._values[face].astype(np.float64))


class VertexColors:
    """Colors (V, 3) uint8 of vertices."""

    legend = Legend("")

    def __init__(self, faces, colors):
        self._faces, self._colors = faces, colors

    def colors(self, face, weights):
        corners = self._colors[self._faces[face]] / 255.0
        return np.einsum("nc,ncd->nd", weights, corners)


class Labels:
    """The faces' labels; of several on one face the last in the order of the mesh."""

    def __init__(self, mesh: Mesh):
        self._colors = np.tile(np.array(PLAIN), (len(mesh.faces), 1))
        entries: List[Tuple[str, Tuple[float, ...]]] = []
        for i, (text, label) in enumerate(mesh.labels.items()):
            color = label_color(label, i, len(mesh.labels))
            self._colors[label.faces] = color
            entries.append(("%s (%d faces)" % (text, len(label.faces)), color))
        classes = len({split_label(text)[0] for text in mesh.labels})
        title = "labels: %d, classes: %d" % (len(entries), classes)
        self.legend = Legend(title, entries=(("no label", PLAIN),) + tuple(entries))

    def colors(self, face, weights):
        return self._colors[face]


def label_color(label, index: int, count: int) -> Tuple[float, ...]:
    """The label's own color, else that of the index-th of count on the rainbow as RViz has it."""
    if label.color is not None:
        return tuple(part / 255.0 for part in label.color)
    return tuple(scale_colors(RAINBOW, np.array([(index + 1) / count]))[0])


class Textures:
    """Textures and colors of the materials; nearest pixel, repeated outside of 0..1."""

    legend = Legend("")

    def __init__(self, mesh: Mesh):
        self._mesh = mesh

    def colors(self, face, weights):
        mesh, materials = self._mesh, self._mesh.materials
        material = materials.face_materials[face]
        colors = materials.colors[material] / 255.0
        if mesh.texture_coordinates is None:
            return colors
        index = materials.texture_indices[material]
        for key, image in mesh.textures.items():
            here = np.flatnonzero(index == key)
            corners = mesh.texture_coordinates[mesh.faces[face[here]]].astype(np.float64)
            u, v = np.einsum("nc,ncd->dn", weights[here], corners) % 1.0
            height, width = image.shape[:2]
            column = np.minimum((u * width).astype(int), width - 1)
            row = np.minimum(((1 - v) * height).astype(int), height - 1)
            colors[here] = _on_plain(image[row, column] / 255.0)
        return colors


def marked_layer(title: str, faces: np.ndarray, costs: np.ndarray, meaning: LayerMeaning, *scale):
    """The paint of a layer whose lethal values are known: they are painted as +inf is.

    costs: (V,) float32; scale: stops and limits, as for VertexValues.
    """
    shown = np.where(meaning.lethal_in(costs), np.float32(np.inf), costs)
    paint = VertexValues(
        title + (" [%s]" % meaning.unit if meaning.unit else ""), faces, shown, *scale
    )
    rule, count = meaning.rule_text(), meaning.count_lethal(costs)
    if rule and count:
        text, color = "lethal, %s (%d)" % (rule, count), LETHAL
        others = [entry for entry in paint.legend.entries if entry[1] != LETHAL]
        paint.legend = paint.legend._replace(entries=((text, color), *others))
    return paint


def _on_plain(pixels):
    if pixels.shape[1] == 3:
        return pixels
    return pixels[:, :3] * pixels[:, 3:] + np.array(PLAIN) * (1 - pixels[:, 3:])


def _value_legend(title, values, stops, limits):
    unknown, lethal = np.count_nonzero(np.isnan(values)), np.count_nonzero(values == np.inf)
    entries = []
    if lethal:
        entries.append(("lethal (%d)" % lethal, LETHAL))
    if unknown:
        entries.append(("unknown (%d)" % unknown, UNKNOWN))
    low, high = finite_limits(values)
    bar = limits if np.isfinite(values).any() else None
    return Legend(title, bar, stops, tuple(entries), (low < limits[0], high > limits[1]))
