"""Which layer reads which, and the order in which they are evaluated."""

import collections
from typing import Container, Dict, List, Mapping, Tuple

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
            readers = self._readers_between(name)
            if name in self.errors or name not in readers:
                continue
            # one circle, as short as possible, of each group of layers that need each other
            steps = [(readers[name], name)]
            while steps[-1][0] != name:
                steps.append((readers[steps[-1][0]], steps[-1][0]))
            text = "cyclic inputs: " + ", ".join("%s reads %s" % step for step in steps[::-1])
            together = {other for other in readers if name in self._readers_between(other)}
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

    def _readers_between(self, name: str) -> Dict[str, str]:
        """All that it reads, directly or through others, each with who reads that on a shortest way
        from it. It is itself among them where it is in a circle."""
        readers: Dict[str, str] = {}
        waiting = collections.deque([name])
        while waiting:
            current = waiting.popleft()
            for read in self.inputs.get(current, ()):
                if read not in readers:
                    readers[read] = current
                    waiting.append(read)
        return readers
