"""Memory of a server that runs for long: what stays, and what is given back."""

import ctypes
import gc

_M_MMAP_THRESHOLD = -3  # in glibc's malloc.h
_LARGE = 1 << 20  # bytes


def settle() -> None:
    """Collect garbage now, and never again look at the objects that there are.

    A server has some hundred thousand objects (modules, types, the map) that live as long as it
    does. A full collection looks at all of them, for 40 ms and more in which no other thread runs,
    and messages with paths cause one every few seconds: cycles of control would come late.

    Calling it again, as for another map, first takes what was set aside into account.
    """
    gc.unfreeze()
    gc.collect()
    gc.freeze()


def give_back_large_arrays() -> bool:
    """Have the system get the memory of large arrays back as soon as nobody uses them.

    By itself, glibc keeps arrays of up to 32 MiB for later, between others that are still in use:
    on a map of a million vertices a hundred megabytes and more. To be called before there are
    threads.

    Returns:
        Whether that could be done; other C libraries are left as they are.
    """
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
    return mallopt is not None and bool(mallopt(_M_MMAP_THRESHOLD, _LARGE))
