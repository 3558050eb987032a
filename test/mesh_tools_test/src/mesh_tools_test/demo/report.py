"""What was done, with times: printed while it happens, written as a table at the end."""
import sys
import time
from contextlib import contextmanager


class Report:
    """Collects one row a step: what, seconds, the result in a sentence."""

    def __init__(self, stream=sys.stdout):
        self.rows = []
        self._stream = stream

    @contextmanager
    def step(self, name):
        """Time a step; the body appends sentences to the list it is given."""
        started = time.monotonic()
        notes = []
        yield notes
        seconds = time.monotonic() - started
        self.rows.append((name, seconds, "; ".join(notes)))
        self._stream.write(f"{name:<22} {seconds:7.2f} s   {'; '.join(notes)}\n")
        self._stream.flush()

    def markdown(self):
        """The table as Markdown text."""
        lines = ["| step | seconds | result |", "|---|---:|---|"]
        for name, seconds, notes in self.rows:
            notes = notes.replace("|", "\\|")
            lines.append(f"| {name} | {seconds:.2f} | {notes} |")
        total = sum(seconds for _, seconds, _ in self.rows)
        return "\n".join(lines + [f"| all | {total:.2f} | |", ""])
