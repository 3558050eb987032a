"""A private X server without a screen."""

import contextlib
import os
import select
import subprocess
from typing import Iterator

from osmesa_harness.processes import stop_group, tied

_START_SECONDS = 30.0


def _display_number(read_end: int) -> str:
    """What Xvfb writes once it accepts connections; an empty string where it ended instead."""
    number = b""
    while not number.endswith(b"\n"):
        ready, _, _ = select.select([read_end], [], [], _START_SECONDS)
        piece = os.read(read_end, 64) if ready else b""
        if not piece:
            return ""
        number += piece
    return number.decode().strip()


@contextlib.contextmanager
def private_x_server(screen: str = "1280x960x24") -> Iterator[str]:
    """Runs Xvfb on a display that it chooses itself, so that parallel runs cannot meet.

    Yields the value for DISPLAY. Raises FileNotFoundError where Xvfb is not installed, RuntimeError
    where it does not start.
    """
    # Looked for here, because it is setpriv that would miss it.
    if not any(
        os.access(os.path.join(folder, "Xvfb"), os.X_OK) for folder in os.get_exec_path() if folder
    ):
        raise FileNotFoundError(2, "not installed", "Xvfb")
    read_end, write_end = os.pipe()
    command = ["Xvfb", "-displayfd", str(write_end), "-screen", "0", screen, "-nolisten", "tcp"]
    command += ["-noreset"]  # after the last client it would refuse the next one for a moment
    try:
        process = subprocess.Popen(
            tied(command),
            pass_fds=(write_end,),
            start_new_session=True,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        os.close(write_end)
        try:
            number = _display_number(read_end)
            if not number:
                raise RuntimeError(
                    f"Xvfb did not start; try it by hand: {' '.join(command[:1])} :99"
                )
            yield f":{number}"
        finally:
            stop_group(process)
    finally:
        os.close(read_end)
