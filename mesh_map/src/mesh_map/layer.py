"""The base class of all layers, and what a layer gives."""

import abc
from typing import TYPE_CHECKING, Any, ClassVar, Dict, List, Mapping, NamedTuple, Optional, Tuple

import numpy as np

from mesh_map.array_checks import read_only
from mesh_map.errors import MeshMapError
from mesh_map.parameter import Parameter, Value

if TYPE_CHECKING:
    from mesh_map.geometry import MeshGeometry
    from mesh_map.mesh_map import MeshMap

BASE_CLASS_TYPE = "mesh_map::Layer"

FACTOR = Parameter(
    "factor", 1.0, 0.0, 1.0, "weight of the costs in the combination", affects_costs=False
)
COMBINATION_WEIGHT = Parameter(
    "combination_weight",
    1.0,
    0.0,
    1.0,
    "weight of the costs in combination layers",
    affects_costs=False,
)


class LayerResult(NamedTuple):
    """What a layer gives.

    costs: (V,) float32; finite >= 0 is a cost, +inf is lethal, NaN is unknown.
    lethal: (V,) bool; True wherever the cost is +inf, and where the layer says so.
    vectors: (V, 3) float32, a direction in which to be drawn at each vertex, zero where there is
        none, such as away from obstacles; None for a layer without.
    """

    costs: np.ndarray
    lethal: np.ndarray
    vectors: Optional[np.ndarray] = None

    def read_only(self) -> "LayerResult":
        """The same with arrays that cannot be written through."""
        vectors = None if self.vectors is None else read_only(self.vectors)
        return LayerResult(read_only(self.costs), read_only(self.lethal), vectors)


class LayerInput(NamedTuple):
    """What a layer reads of another one: its result, and its combination_weight."""

    costs: np.ndarray
    lethal: np.ndarray
    vectors: Optional[np.ndarray]
    weight: float


class Layer(abc.ABC):
    """A cost for each vertex of a map, and which vertices are lethal.

    The contract of a layer plugin:

    * It is described in an XML file that its package.xml exports (see mesh_map.plugins), and
      constructed with its name and parameters, which are checked against PARAMETERS; a plugin need
      not define __init__.
    * compute() gets the map and the results of its inputs, and returns costs and lethal vertices.
      It must not change the map or the inputs, and may be called again at any time, after
      parameters have changed. It may raise MeshMapError with one line for users.
    * A layer that sets READS_LAYERS has inputs: the layers that its parameter "inputs" (a list of
      names) says, or all layers before it in the list.
    * It does not import rospy and knows nothing of ROS. One that needs data from topics names a
      class for that in ROS_ADAPTER (see mesh_map.ros_adapter).

    The same type may be used several times in a map under different names. The map calls one method
    of a layer at a time.

    Attributes:
        name: unique in its map; also the type of its costs messages and its name in the map file.
        type_name: the name under which the plugin was asked for, such as
            mesh_layers/HeightDiffLayer.
        params: parameter name -> value, all of them.
        inputs: names from the parameter "inputs"; None if it was not given.
        warnings: what was odd about the parameters, one line each.
        result: set by the map after compute(); None before.
        identity: fingerprint() at that time.
    """

    PARAMETERS: ClassVar[Tuple[Parameter, ...]] = ()
    READS_LAYERS: ClassVar[bool] = False
    ROS_ADAPTER: ClassVar[str] = ""

    def __init__(
        self, name: str, params: Optional[Mapping[str, Any]] = None, type_name: str = ""
    ) -> None:
        """Checks the parameters.

        Raises:
            MeshMapError: one that is NaN or of another type.
        """
        self.name = name
        self.type_name = type_name or type(self).__name__
        self.params: Dict[str, Value] = {}
        self.inputs: Optional[Tuple[str, ...]] = None
        self.warnings: List[str] = []
        self.result: Optional[LayerResult] = None
        self.identity: Dict[str, Value] = {}
        given = dict(params or {})
        if self.READS_LAYERS:
            self.inputs = _checked_inputs(given.pop("inputs", None))
        for parameter in self.all_parameters():
            value = given.pop(parameter.name, parameter.default)
            self.params[parameter.name], warning = parameter.checked(value)
            if warning:
                self.warnings.append(warning)
        if given:
            known = ", ".join(sorted(self.params))
            unknown = ", ".join(sorted(map(str, given)))
            self.warnings.append("unknown parameters: %s (known: %s)" % (unknown, known))

    @classmethod
    def all_parameters(cls) -> Tuple[Parameter, ...]:
        """PARAMETERS and those that every layer has."""
        return cls.PARAMETERS + (FACTOR, COMBINATION_WEIGHT)

    def announce(self, geometry: "MeshGeometry") -> None:
        """Called for all layers that will be computed, before any is.

        For layers that share an expensive pass over the mesh: here each says what it needs of it.
        """

    @abc.abstractmethod
    def compute(self, mesh_map: "MeshMap", inputs: Mapping[str, LayerInput]) -> LayerResult:
        """Costs and lethal vertices.

        Args:
            mesh_map: the map; its arrays are read-only.
            inputs: of a layer that reads layers, in the order of its parameter "inputs", or of the
                list; empty for others.
        Returns:
            costs (V,), and lethal as (V,) bool or as indices of vertices. Lethal costs (+inf) need
            not be repeated there. Vectors (V, 3) may follow.
        """

    def update(
        self,
        mesh_map: "MeshMap",
        inputs: Mapping[str, LayerInput],
        changed: np.ndarray,
        before: LayerResult,
    ) -> LayerResult:
        """compute() where only some vertices of the inputs have changed: the same, bit for bit.

        Called with parameters as at the time of `before`. The default computes everything; a
        layer that can do better copies the arrays of `before` and changes them where needed.

        Args:
            mesh_map, inputs: as for compute().
            changed: (K,) uint32, ascending: the vertices at which some input has changed; may be
                empty where the layer's own data (of a sensor) have changed.
            before: the result that this layer had; its arrays are read-only.
        """
        return self.compute(mesh_map, inputs)

    def reuse(self, costs: np.ndarray) -> Optional[LayerResult]:
        """The result with costs that were computed before with the same fingerprint().

        None (the default) for a layer that has to be computed, for instance because it depends on
        data of a sensor. Also called when only parameters change that do not affect costs.
        """
        return None

    def fingerprint(
        self, mesh_map: "MeshMap", inputs: Mapping[str, LayerInput]
    ) -> Dict[str, Value]:
        """What is stored with the costs: they may be reused where this is the same.

        By default the type, the parameters that affect costs, and the geometry. Layers that read
        layers or contents of the map file add a digest of what they read.
        """
        affecting = {p.name: self.params[p.name] for p in self.all_parameters() if p.affects_costs}
        return dict(affecting, type=self.type_name, geometry=mesh_map.geometry.content_uuid)

    def evaluate(self, mesh_map: "MeshMap", inputs: Mapping[str, LayerInput]) -> LayerResult:
        """compute(), with what it returns checked and brought into the form of LayerResult.

        Raises:
            MeshMapError: arrays of a wrong length or kind, or a negative cost.
        """
        return checked(self.compute(mesh_map, inputs), len(mesh_map.vertices))


def checked(returned: Any, vertex_count: int) -> LayerResult:
    """What compute() or update() returned, in the form of LayerResult.

    Raises:
        MeshMapError: arrays of a wrong length or kind, or a negative cost.
    """
    try:
        costs, lethal, *vectors = returned
    except (TypeError, ValueError) as error:
        raise MeshMapError("compute() did not return costs and lethal vertices") from error
    return checked_result(costs, lethal, vertex_count, *vectors)


def checked_result(
    costs: Any, lethal: Any, vertex_count: int, vectors: Optional[Any] = None
) -> LayerResult:
    """A LayerResult of V costs, V booleans or any number of vertex indices, and (V, 3) vectors.

    Raises:
        MeshMapError: arrays of a wrong length or kind, or a negative cost.
    """
    costs, lethal = np.asarray(costs), np.asarray(lethal)
    if costs.dtype.kind not in "fiu" or costs.shape != (vertex_count,):
        raise MeshMapError(
            "the costs are of shape %s and type %s, but %d numbers are needed, one for each vertex"
            % (costs.shape, costs.dtype, vertex_count)
        )
    if lethal.dtype.kind == "b" and lethal.shape == (vertex_count,):
        mask = lethal
    elif lethal.ndim == 1 and (lethal.dtype.kind in "iu" or not len(lethal)):
        indices = lethal.astype(np.int64)
        if len(indices) and not 0 <= indices.min() <= indices.max() < vertex_count:
            raise MeshMapError("a lethal vertex does not exist: there are %d" % vertex_count)
        mask = np.zeros(vertex_count, np.bool_)
        mask[indices] = True
    else:
        raise MeshMapError("the lethal vertices have to be %d booleans or indices" % vertex_count)
    with np.errstate(over="ignore"):  # what does not fit is lethal
        costs = np.ascontiguousarray(costs, np.float32)
    negative = np.flatnonzero(costs < 0)
    if len(negative):
        raise MeshMapError(
            "the cost of vertex %d is %g (%d negative ones in all)"
            % (negative[0], costs[negative[0]], len(negative)),
            "costs have to be 0 or more, +inf for lethal, NaN for unknown",
        )
    if vectors is not None:
        vectors = np.ascontiguousarray(vectors, np.float32)
        if vectors.shape != (vertex_count, 3) or not np.isfinite(vectors).all():
            raise MeshMapError("the vectors have to be (%d, 3) finite numbers" % vertex_count)
    return LayerResult(costs, mask | np.isposinf(costs), vectors)


def _checked_inputs(value: Any) -> Optional[Tuple[str, ...]]:
    if value is None:
        return None
    if not isinstance(value, (list, tuple)) or not all(isinstance(name, str) for name in value):
        raise MeshMapError("inputs is %r, but it has to be a list of names of layers" % (value,))
    if len(set(value)) < len(value):
        raise MeshMapError("inputs names a layer twice: %s" % ", ".join(value))
    return tuple(value)
