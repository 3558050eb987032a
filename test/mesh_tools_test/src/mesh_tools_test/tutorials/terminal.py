"""A terminal as the reader of a tutorial has one: a bash that lives as long as the page."""
import contextlib
import os
import shlex
import signal
import subprocess
import tempfile
import threading
import time
from pathlib import Path
from typing import Mapping, Optional

from osmesa_harness.processes import tied

_PATIENCE = 30.0  # seconds after Ctrl+C


class Terminal:
    """A bash that ends at the first command that fails.

    :param folder: where it begins
    :param environment: of all that is started in it
    """

    def __init__(self, folder, environment: Mapping[str, str]):
        self._process = subprocess.Popen(
            tied(["bash", "--noprofile", "--norc"], "INT"),
            cwd=str(folder),
            env=dict(environment),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        self._blocks = tempfile.TemporaryDirectory()
        self._count = 0
        self._output = b""
        self._has_ended = False
        self._changed = threading.Condition()
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()
        self._write("set -eo pipefail")

    def _read(self):
        data = b"begin"
        while data:
            data = os.read(self._process.stdout.fileno(), 1 << 16)
            with self._changed:
                self._output += data
                self._has_ended = not data
                self._changed.notify_all()

    def _write(self, line):
        try:
            self._process.stdin.write((line + "\n").encode())
            self._process.stdin.flush()
        except BrokenPipeError:
            pass  # the bash has ended: what it printed tells why

    def _source(self, commands):
        """From a file: a command that reads its input would eat what is typed next."""
        self._count += 1
        block = Path(self._blocks.name, "%d.bash" % self._count)
        block.write_text(commands, encoding="utf-8")
        self._write("source %s </dev/null" % shlex.quote(str(block)))

    def output(self) -> str:
        """All that it has printed."""
        with self._changed:
            return self._output.decode("utf-8", "replace")

    def type(self, commands: str):
        """Commands that are not waited for; one that fails, or is interrupted, is not the end."""
        self._write("set +e")
        self._source(commands)

    def run(self, commands: str, seconds: float) -> Optional[str]:
        """Commands that end; returns what they printed, None if one failed or time was over."""
        with self._changed:
            begin = len(self._output)
        self._source(commands)
        mark = "[end of block %d]\n" % self._count
        self._write("printf %s" % shlex.quote(mark.replace("\n", "\\n")))
        end = time.monotonic() + seconds
        with self._changed:
            while mark.encode() not in self._output[begin:]:
                if self._has_ended or time.monotonic() > end:
                    return None
                self._changed.wait(0.5)
            found = self._output[begin:].decode("utf-8", "replace")
        return found[: found.index(mark)]

    def close(self):
        """Ctrl+C to all that runs in it, then its end."""
        self._write("exit")
        for number, patience in ((signal.SIGINT, _PATIENCE), (signal.SIGKILL, _PATIENCE)):
            try:
                os.killpg(self._process.pid, number)
            except ProcessLookupError:
                break
            if _is_gone(self._process, patience):
                break
        self._process.wait()
        with contextlib.suppress(BrokenPipeError):  # what is not written yet
            self._process.stdin.close()
        self._reader.join(_PATIENCE)
        self._process.stdout.close()
        self._blocks.cleanup()


def _is_gone(process, seconds):
    """Whether a process and the group it leads end in that time."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        process.poll()
        try:
            os.killpg(process.pid, 0)
        except ProcessLookupError:
            return True
        time.sleep(0.05)
    return False
