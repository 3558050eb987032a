"""What was done, with times: printed while it happens, written as a table at the end."""
import sys
import time
from contextlib import contextmanager


class Report:
    """Collects one row a step: what, seconds, the result in a sentence; and tables of results."""

    def __init__(self, stream=sys.stdout):
        self.rows = []
        self._tables = []
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

    def table(self, rows):
        """Print a table of texts whose first row is its header, and keep it for the end."""
        widths = [max(map(len, column)) for column in zip(*rows)]
        for row in rows:
            first, others = row[0].ljust(widths[0]), zip(row[1:], widths[1:])
            line = "   ".join([first, *(text.rjust(width) for text, width in others)])
            self._stream.write(f"    {line.rstrip()}\n")
        self._stream.flush()
        lines = [f"| {' | '.join(row)} |" for row in rows]
        lines.insert(1, "|---" + "|---:" * (len(widths) - 1) + "|")
        self._tables.append("\n".join([*lines, ""]))

    def markdown(self):
        """The steps and the tables as Markdown text."""
        lines = ["| step | seconds | result |", "|---|---:|---|"]
        for name, seconds, notes in self.rows:
            notes = notes.replace("|", "\\|")
            lines.append(f"| {name} | {seconds:.2f} | {notes} |")
        total = sum(seconds for _, seconds, _ in self.rows)
        steps = "\n".join(lines + [f"| all | {total:.2f} | |", ""])
        return "\n".join([steps, *self._tables])
