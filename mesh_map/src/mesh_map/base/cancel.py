"""How to end something long from another thread."""

from typing import Any, Optional

from mesh_map import _kernels


class CancelFlag:
    """Ends what it is given to; may be set before or while that runs, by any thread."""

    def __init__(self) -> None:
        self._kernel = _kernels._CancelFlag()

    def set(self) -> None:
        self._kernel._set()

    def is_set(self) -> bool:
        return self._kernel._is_set()


def kernel_flag(cancel: Optional[CancelFlag]) -> Any:
    """What the kernels look at.

    Raises:
        ValueError: neither a CancelFlag nor None.
    """
    if cancel is None:
        return None
    if not isinstance(cancel, CancelFlag):
        raise ValueError(
            "cancel has to be a mesh_map.base.cancel.CancelFlag, not a %s" % type(cancel).__name__
        )
    return cancel._kernel
