"""Which layer reads which, and the order in which they are evaluated."""

from typing import Container, Dict, List, Mapping, Set, Tuple

from mesh_map.costs.layer import Layer


class LayerGraph:
    """Dependencies between layers.

    A layer that reads layers reads those that its parameter "inputs" names, wherever they are in
    the list, or without it all that are before it in the list.

    Attributes:
        order: names of the layers that can be evaluated, inputs before those who read them, and
            otherwise in the order of the list.
        inputs: name -> names of what it reads: of "inputs" in that order, or of the list.
        errors: name -> one line, for the layers that cannot be evaluated: they read what does not
            exist, or are in a circle.
    """

    def __init__(self, layers: Mapping[str, Layer], left_out: Container[str] = ()) -> None:
        """Finds the order.

        Args:
            layers: by their names, in the order of the list.
            left_out: names of others, which may be read as far as this class is concerned.
        """
        self.inputs: Dict[str, Tuple[str, ...]] = {}
        names = list(layers)
        for number, (name, layer) in enumerate(layers.items()):
            if not layer.READS_LAYERS:
                self.inputs[name] = ()
            elif layer.inputs is None:
                self.inputs[name] = tuple(names[:number])
            else:
                self.inputs[name] = layer.inputs
        self.errors: Dict[str, str] = {}
        for name, inputs in list(self.inputs.items()):
            unknown = [read for read in inputs if read not in layers and read not in left_out]
            if unknown:
                others = ", ".join(other for other in names if other != name) or "none"
                self.errors[name] = "its input %s is no layer (known: %s)" % (unknown[0], others)
                del self.inputs[name]
        for name in self.inputs:
            circle = [] if name in self.errors else self._circle_through(name)
            if circle:  # one, as short as possible, of each group of layers that need each other
                text = "cyclic inputs: " + ", ".join(
                    "%s reads %s" % pair for pair in zip(circle, circle[1:] + circle[:1])
                )
                together = self._strongly_connected(name)
                self.errors.update((other, text) for other in names if other in together)
        for name in self.errors:
            self.inputs.pop(name, None)
        self.order = self._sorted()

    def _sorted(self) -> List[str]:
        """Again and again the first of the list of which all inputs are there."""
        order: List[str] = []
        waiting = dict(self.inputs)
        while waiting:
            name = next(name for name in waiting if waiting.keys().isdisjoint(waiting[name]))
            order.append(name)
            del waiting[name]
        return order

    def _circle_through(self, name: str) -> List[str]:
        """name, what it reads, what that reads, ... up to one that reads name; or nothing."""
        came_from: Dict[str, str] = {}
        layer = [name]
        while layer:
            following = []
            for current in layer:
                for read in self.inputs.get(current, ()):
                    if read == name:
                        way = [current]
                        while way[-1] != name:
                            way.append(came_from[way[-1]])
                        return way[::-1]
                    if read not in came_from:
                        came_from[read] = current
                        following.append(read)
            layer = following
        return []

    def _reachable(self, name: str) -> Set[str]:
        """What it reads, directly or through others."""
        found: Set[str] = set()
        waiting = [name]
        while waiting:
            for read in self.inputs.get(waiting.pop(), ()):
                if read not in found:
                    found.add(read)
                    waiting.append(read)
        return found

    def _strongly_connected(self, name: str) -> Set[str]:
        """The layers in any circle with this one, and itself."""
        return {name} | {
            other
            for other in self._reachable(name)
            if other in self.inputs and name in self._reachable(other)
        }
