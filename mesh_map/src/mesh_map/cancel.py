"""How to end something long from another thread."""

from mesh_map import _kernels


class CancelFlag:
    """Ends what it is given to; may be set before or while that runs, by any thread."""

    def __init__(self) -> None:
        self._kernel = _kernels._CancelFlag()

    def set(self) -> None:
        self._kernel._set()

    def is_set(self) -> bool:
        return self._kernel._is_set()
