"""A process with plugins ends when it is told to, whatever they do."""

import os
import signal

from mesh_map import _kernels

END_SECONDS = 2.7


def end_when_told(seconds: float = END_SECONDS) -> None:
    """From now on, this process ends so long after SIGINT or SIGTERM at the latest.

    What it does by itself until then counts. Afterwards a thread in native code ends it with the
    exit code 128 + signal and a line on stderr, also where a plugin holds Python's lock. Needs a
    handler for these signals in Python; to be called once, in the main thread.

    Args:
        seconds: wall time.
    Raises:
        ValueError: this is not the main thread.
    """
    reading, writing = os.pipe()
    os.set_blocking(writing, False)
    signal.set_wakeup_fd(writing, warn_on_full_buffer=False)
    _kernels._start_end_watch(reading, seconds)
