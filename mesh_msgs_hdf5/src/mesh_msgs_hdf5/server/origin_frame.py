"""Where the origin of a map goes in the tree of frames."""
from typing import Dict, Mapping, Optional


class FrameTree:
    """The parents of frames, as static transforms of all nodes tell them.

    parents: child -> (parent, node).
    """

    def __init__(self) -> None:
        self._parents: Dict[str, Dict[str, str]] = {}

    def add(self, child: str, parent: str, node: str) -> None:
        """A node says that this frame has this parent."""
        self._parents.setdefault(child.lstrip("/"), {})[node] = parent.lstrip("/")

    def refusal(self, parent: str, child: str, node: str) -> str:
        """Why the node may not give the frame this parent; "" if it may.

        A frame has one parent: two of them tear the tree apart whenever one is sent again.
        """
        if parent == child:
            return "it is the frame of the map itself"
        for other, its_parent in self._of(child).items():
            if other != node or its_parent != parent:
                return "frame %s already has the parent %s (from %s)" % (child, its_parent, other)
        seen, above = {parent}, self._above(parent)
        while above is not None and above not in seen:
            if above == child:
                return "%s is below %s already: frames would go round in a circle" % (parent, child)
            seen.add(above)
            above = self._above(above)
        return ""

    def _of(self, child: str) -> Mapping[str, str]:
        return self._parents.get(child, {})

    def _above(self, child: str) -> Optional[str]:
        return next(iter(self._of(child).values()), None)
