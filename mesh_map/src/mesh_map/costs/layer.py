"""What a layer is: the base class of all, what it gets of others, and what it gives."""

import abc
import json
import math
from typing import TYPE_CHECKING, Any, ClassVar, Dict, List, Mapping, NamedTuple, Optional, Tuple

import numpy as np

from mesh_map.base.array_checks import read_only
from mesh_map.base.digest import digest
from mesh_map.base.errors import MeshMapError
from mesh_map.base.parameter import Parameter, Value, checked_values
from mesh_map.costs.lethal_rule import LethalRule
from mesh_map.geometry.mesh_geometry import MeshGeometry


if TYPE_CHECKING:
    from mesh_map.map.mesh_map import MeshMap

BASE_CLASS_TYPE = "mesh_map::Layer"
ON_TRUST = "on_trust"  # in the identity of a layer whose costs are of a file that says nothing

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
ENABLED = Parameter(
    "enabled",
    True,
    description="false takes the layer out, with what is lethal and unknown in it, and does not "
    "evaluate it; those that read it find it free, with weight 0",
    affects_costs=False,
)
OF_ALL = (FACTOR, COMBINATION_WEIGHT, ENABLED)


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

    @classmethod
    def free(cls, vertex_count: int) -> "LayerResult":
        """What a layer has that is not enabled: no costs, and nothing lethal."""
        costs, lethal = np.zeros(vertex_count, np.float32), np.zeros(vertex_count, np.bool_)
        return cls(read_only(costs), read_only(lethal))


class LayerInput(NamedTuple):
    """What a layer reads of another one: its result, and its combination_weight."""

    costs: np.ndarray
    lethal: np.ndarray
    vectors: Optional[np.ndarray]
    weight: float


Inputs = Mapping[str, LayerInput]  # of a layer, by the names of the layers that it reads


def checked(returned: Any, vertex_count: int) -> LayerResult:
    """What compute() or update() returned: costs (V,), lethal vertices, vectors or nothing.

    Lethal vertices are V booleans or any number of indices, vectors (V, 3). The arrays of the
    result are read-only; what the caller could still write to is copied.

    Raises:
        MeshMapError: arrays of a wrong length or kind, or a negative cost.
    """
    try:
        costs, lethal, *more = returned
        (vectors,) = more or (None,)
    except (TypeError, ValueError) as error:
        raise MeshMapError("compute() did not return costs and lethal vertices") from error
    given_costs, given_vectors = costs, vectors
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
    negative = costs < 0
    if negative.any():
        negative = np.flatnonzero(negative)
        raise MeshMapError(
            "the cost of vertex %d is %g (%d negative ones in all)"
            % (negative[0], costs[negative[0]], len(negative)),
            "costs have to be 0 or more, +inf for lethal, NaN for unknown",
        )
    if vectors is not None:
        with np.errstate(over="ignore"):  # what does not fit is not finite
            vectors = np.ascontiguousarray(vectors, np.float32)
        if vectors.shape != (vertex_count, 3) or not np.isfinite(vectors).all():
            raise MeshMapError("the vectors have to be (%d, 3) finite numbers" % vertex_count)
        vectors = _of_its_own(vectors, given_vectors)
    mask = mask | (costs == np.inf)
    return LayerResult(_of_its_own(costs, given_costs), read_only(mask), vectors)


def digest_of_inputs(inputs: Inputs, weights: bool = True) -> str:
    """A digest of names, costs, lethal vertices and vectors of inputs, and of their weights."""
    parts: List[Any] = []
    for name, read in inputs.items():
        parts += [name, repr(read.weight) if weights else "", read.costs, read.lethal]
        parts.append("" if read.vectors is None else read.vectors)
    return digest(*parts)


def _of_its_own(array: np.ndarray, given: Any) -> np.ndarray:
    """Read-only, and nobody else can write to it: a layer may use its buffers again."""
    if (
        isinstance(given, np.ndarray)
        and given.flags.writeable
        and np.may_share_memory(array, given)
    ):
        array = array.copy()
    return read_only(array)


class Layer(abc.ABC):
    """A cost for each vertex of a map, and which vertices are lethal.

    The contract of a layer plugin:

    * It is described in an XML file that its package.xml exports (see mesh_map.base.plugins), and
      constructed with its name and parameters, which are checked against PARAMETERS; a plugin need
      not define __init__.
    * compute() gets the map and the results of its inputs, and returns costs and lethal vertices.
      It must not change the map or the inputs, and may be called again at any time, after
      parameters have changed. It may raise MeshMapError with one line for users.
    * A layer that sets READS_LAYERS has inputs: the layers that its parameter "inputs" (a list of
      names) says, or all layers before it in the list that have a result. It is evaluated again
      when one of them changes; when only their combination_weight does, unless it says that it does
      not look at weights with READS_WEIGHTS = False.
    * One that keeps what sensors have seen overrides clear(), so that it can be forgotten.
    * It does not import rospy and knows nothing of ROS. One that needs data from topics names a
      class for that in ROS_ADAPTER (see mesh_map.ros.ros_adapter).
    * People are told what its costs mean: UNIT, such as "m", and lethal_rule().
    * Its costs are stored with the map and reused, unless it says STORABLE = False, because they
      are made quickly from what is in the file, or are of the moment only.
    * One that the released programs store says under which name with RELEASED_NAME; what they have
      stored may be used (see mesh_map.costs.trust), within largest_cost().

    The same type may be used several times in a map under different names. The map calls one method
    of a layer at a time, from any thread; a layer whose call has not returned within the
    layer_timeout of the map is not called any more, however it gets on: progress cannot be told.

    Attributes:
        name: unique in its map; also the type of its costs messages and its name in the map file.
        type_name: the name under which the plugin was asked for, such as
            mesh_layers/HeightDiffLayer.
        params: parameter name -> value, all of them.
        inputs: names from the parameter "inputs"; None if it was not given.
        warnings: what was odd about the parameters, one line each.
        result: set by the map after compute(); None before, LayerResult.free() while "enabled" is
            false. Its arrays are read-only; those that compute() returned are copied, unless they
            are read-only themselves.
    """

    PARAMETERS: ClassVar[Tuple[Parameter, ...]] = ()
    READS_LAYERS: ClassVar[bool] = False
    READS_WEIGHTS: ClassVar[bool] = True
    ROS_ADAPTER: ClassVar[str] = ""
    STORABLE: ClassVar[bool] = True
    RELEASED_NAME: ClassVar[str] = ""
    UNIT: ClassVar[str] = ""

    def __init__(
        self, name: str, params: Optional[Mapping[str, Any]] = None, type_name: str = ""
    ) -> None:
        """Checks the parameters.

        Raises:
            MeshMapError: one that is NaN or of another type.
        """
        self.name = name
        self.type_name = type_name or type(self).__name__
        self.inputs: Optional[Tuple[str, ...]] = None
        self.result: Optional[LayerResult] = None
        self._identity: Optional[Dict[str, Value]] = {}
        self._evaluated_with: Tuple[Any, ...] = ()
        given = dict(params or {})
        if self.READS_LAYERS:
            self.inputs = _checked_inputs(given.pop("inputs", None))
        self.params, self.warnings = self._checked(given)

    @property
    def identity(self) -> Dict[str, Value]:
        """fingerprint() of the result; empty before there is one. Computed when asked for."""
        if self._identity is None:
            self._identity = self.fingerprint(*self._evaluated_with)
        return self._identity

    @identity.setter
    def identity(self, fingerprint: Dict[str, Value]) -> None:
        self._identity = fingerprint

    def evaluated(self, result: LayerResult, mesh_map: "MeshMap", inputs: Inputs) -> None:
        """Called by the map: the layer has a new result, of these inputs."""
        before = self.result
        kept = before is not None and np.may_share_memory(result.costs, before.costs)
        on_trust = kept and ON_TRUST in (self._identity or ())  # they get no fingerprint
        self.result = result
        self._identity = self._identity if on_trust else None
        self._evaluated_with = mesh_map, inputs

    def checked_changes(self, values: Mapping[str, Any]) -> Tuple[Dict[str, Value], List[str]]:
        """All parameters with other values of some, and warnings; nothing is changed by this.

        Raises:
            MeshMapError: one that is NaN or of another type, or "inputs", which stay as they are.
        """
        if "inputs" in values and self.READS_LAYERS:
            raise MeshMapError("inputs cannot be changed while the layer is in use")
        return self._checked({**self.params, **values})

    def _checked(self, given: Mapping[str, Any]) -> Tuple[Dict[str, Value], List[str]]:
        """All parameters, as given or by default, and warnings."""
        params, warnings = checked_values(self.all_parameters(), given)
        unknown = sorted(str(name) for name in given if name not in params)
        if unknown:
            names = ", ".join(unknown), ", ".join(sorted(params))
            warnings.append("unknown parameters: %s (known: %s)" % names)
        return params, warnings

    @classmethod
    def all_parameters(cls) -> Tuple[Parameter, ...]:
        """PARAMETERS, and those that every layer has unless it declares them itself."""
        own = {parameter.name for parameter in cls.PARAMETERS}
        return cls.PARAMETERS + tuple(p for p in OF_ALL if p.name not in own)

    def lethal_rule(self) -> Optional[LethalRule]:
        """Which costs are lethal with the parameters of now; None (the default): only +inf.

        For people alone: what is lethal is what compute() says. Where the rule says something
        else, it is not told.
        """
        return None

    def largest_cost(self, geometry: MeshGeometry) -> float:
        """What finite costs cannot exceed, whatever the parameters; +inf (the default): nothing."""
        return math.inf

    def sees_steps(self) -> bool:
        """Whether no upright step escapes it that has no vertex between its ends; False by default.

        For people alone, who are warned of such steps where no layer sees them.
        """
        return False

    def announce(self, geometry: MeshGeometry) -> None:
        """Called for all layers that will be computed, before any is.

        For layers that share an expensive pass over the mesh: here each says what it needs of it.
        """

    @abc.abstractmethod
    def compute(self, mesh_map: "MeshMap", inputs: Inputs) -> LayerResult:
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
        self, mesh_map: "MeshMap", inputs: Inputs, changed: np.ndarray, before: LayerResult
    ) -> LayerResult:
        """compute() where only some vertices of the inputs have changed: the same, bit for bit.

        Called with parameters as at the time of `before`. The default computes everything; a
        layer that can do better copies the arrays of `before` and changes them where needed.

        Args:
            mesh_map, inputs: as for compute().
            changed: (K,) uint32, ascending: the vertices at which some input has changed; may be
                empty where the layer's own data (of a sensor) have changed.
            before: the result that this layer has; its arrays are read-only. It need not be what
                was returned last: a change that fails elsewhere is given up as a whole.
        """
        return self.compute(mesh_map, inputs)

    def clear(self) -> int:
        """Forgets what sensors have seen so far; the map evaluates the layer afterwards.

        Layers of what does not change have nothing to forget: they leave this as it is.

        Returns:
            how many things were forgotten, whatever the layer counts.
        """
        return 0

    @classmethod
    def can_be_cleared(cls) -> bool:
        """Whether clear() does anything."""
        return cls.clear is not Layer.clear

    def reuse(
        self, costs: np.ndarray, mesh_map: "MeshMap", inputs: Inputs
    ) -> Optional[LayerResult]:
        """The result with costs that were computed before with the same fingerprint().

        Also called when only parameters change that do not affect costs.

        Args:
            costs: (V,) float32, read-only.
            mesh_map, inputs: as for compute(), and the same as when the costs were computed.
        Returns:
            None (the default) where the layer has to be computed, for instance because it depends
            on data of a sensor, or because its result has more to it than follows from these.
        """
        return None

    def fingerprint(self, mesh_map: "MeshMap", inputs: Inputs) -> Dict[str, Value]:
        """What is stored with the costs: they may be reused where this is the same.

        By default the type, the parameters that affect costs (lists and dictionaries as JSON), the
        geometry, and of a layer that reads layers a digest of all that it reads. Layers that read
        contents of the map file add a digest of these.
        """
        found = {p.name: self.params[p.name] for p in self.all_parameters() if p.affects_costs}
        for name, value in found.items():
            if isinstance(value, (tuple, dict)):
                found[name] = json.dumps(value, sort_keys=True)
        found.update(type=self.type_name, geometry=mesh_map.geometry.content_uuid)
        if self.READS_LAYERS:
            found["inputs"] = digest_of_inputs(inputs, self.READS_WEIGHTS)
        return found

    def evaluate(self, mesh_map: "MeshMap", inputs: Inputs) -> LayerResult:
        """compute(), with what it returns checked and brought into the form of LayerResult.

        Raises:
            MeshMapError: arrays of a wrong length or kind, or a negative cost.
        """
        return checked(self.compute(mesh_map, inputs), len(mesh_map.vertices))


def _checked_inputs(value: Any) -> Optional[Tuple[str, ...]]:
    if value is None:
        return None
    if not isinstance(value, (list, tuple)) or not all(isinstance(name, str) for name in value):
        raise MeshMapError("inputs is %r, but it has to be a list of names of layers" % (value,))
    if len(set(value)) < len(value):
        raise MeshMapError("inputs names a layer twice: %s" % ", ".join(value))
    return tuple(value)
