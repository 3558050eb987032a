"""Progress of long work, on a terminal only.

A line on stderr says what is being done, how much of it is done (if that is known) and for how
long; it appears when the work takes longer than a moment, and goes when the work ends.
"""
import sys
import threading
from typing import Optional

try:
    from tqdm import tqdm
except ImportError:  # then nothing is shown
    tqdm = None

_DELAY, _EVERY = 0.7, 0.2  # seconds


class ProgressLine:
    """A context manager; with quiet, or where stderr is no terminal, it does nothing."""

    def __init__(self, quiet: bool = False) -> None:
        self._text = ""
        self._part: Optional[float] = None
        self._ended = threading.Event()
        self._thread = None
        if tqdm is not None and not quiet and sys.stderr.isatty():
            self._thread = threading.Thread(target=self._show, daemon=True)

    def __enter__(self) -> "ProgressLine":
        if self._thread is not None:
            self._thread.start()
        return self

    def __exit__(self, *error) -> None:
        self._ended.set()
        if self._thread is not None:
            self._thread.join()

    def stage(self, text: str) -> None:
        """What is being done now."""
        self._text, self._part = text, None

    def part(self, part: float) -> None:
        """How much of the stage is done, from 0 to 1."""
        self._part = part

    def write(self, line: str) -> None:
        """A line on stderr that stays; what is being done is shown below it."""
        if self._thread is None:
            sys.stderr.write(line + "\n")
        else:
            _Bar.write(line, file=sys.stderr)

    def _show(self):
        if self._ended.wait(_DELAY):
            return
        bar = _Bar(total=100, leave=False, file=sys.stderr, dynamic_ncols=True)
        while True:
            part = self._part
            shape = "" if part is None else " {percentage:3.0f}%|{bar}|"
            bar.bar_format = "{desc}" + shape + " {elapsed}"
            bar.n = 100 * min(1.0, part or 0.0)
            bar.set_description_str(self._text)  # and draws it
            if self._ended.wait(_EVERY):
                bar.close()
                return


if tqdm is not None:

    class _Bar(tqdm):
        monitor_interval = 0  # no thread besides ours
