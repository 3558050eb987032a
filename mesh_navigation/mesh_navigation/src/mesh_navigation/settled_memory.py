"""Python's garbage collector, kept away from what stays."""

import gc


def settle() -> None:
    """Collect now, and never again look at the objects that there are.

    A server has some hundred thousand objects (modules, types, the map) that live as long as it
    does. A full collection looks at all of them, for 40 ms and more in which no other thread runs,
    and messages with paths cause one every few seconds: cycles of control would come late.

    Calling it again, as for another map, first takes what was set aside into account.
    """
    gc.unfreeze()
    gc.collect()
    gc.freeze()
