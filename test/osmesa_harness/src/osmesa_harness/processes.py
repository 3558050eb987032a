"""Child processes that never outlive this one."""

import os
import signal
import subprocess
import time
from types import FrameType
from typing import Mapping, Optional, Sequence

TIMED_OUT = 124
_TERM_SECONDS = 5.0
_KILL_SECONDS = 1.0
_FORWARDED = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


def tied(command: Sequence[str], signal_name: str = "TERM") -> Sequence[str]:
    """`command`, sent that signal by the kernel when this process dies, however it dies."""
    return ["setpriv", "--pdeathsig", signal_name, *command]


def with_variables(command: Sequence[str], variables: Mapping[str, str]) -> Sequence[str]:
    """`command` with these variables set at the very last moment, for LD_PRELOAD above all."""
    return ["env", *(f"{name}={value}" for name, value in variables.items()), *command]


def exit_status(return_code: int) -> int:
    """A shell's exit status: 128 + n for a process that signal n ended."""
    return return_code if return_code >= 0 else 128 - return_code


def kill_group(process: "subprocess.Popen[bytes]", number: int) -> None:
    """Sends a signal to all that is left of a process started as the leader of its session."""
    try:
        os.killpg(process.pid, number)
    except ProcessLookupError:
        pass


def _wait_for_group(process: "subprocess.Popen[bytes]", seconds: float) -> None:
    deadline = time.monotonic() + seconds
    while time.monotonic() < deadline:
        process.poll()  # else the leader stays as a zombie, and its group with it
        try:
            os.killpg(process.pid, 0)
        except ProcessLookupError:
            return
        time.sleep(0.02)


def stop_group(process: "subprocess.Popen[bytes]", seconds: float = _TERM_SECONDS) -> None:
    """Ends the process and what it started: SIGTERM, and after `seconds` SIGKILL."""
    kill_group(process, signal.SIGTERM)
    _wait_for_group(process, seconds)
    kill_group(process, signal.SIGKILL)
    process.wait()
    _wait_for_group(process, _KILL_SECONDS)


def run(
    command: Sequence[str], environment: Mapping[str, str], timeout: Optional[float] = None
) -> int:
    """Runs `command` to its end and returns its exit status, TIMED_OUT after `timeout` seconds.

    SIGINT, SIGTERM and SIGHUP are passed on to it. Whatever it leaves running is ended, too. Where
    this process is killed itself, the program gets SIGTERM, and has to end its own children.
    Raises FileNotFoundError where there is no such program.
    """
    preload = {key: environment[key] for key in ("LD_PRELOAD",) if key in environment}
    without = {key: value for key, value in environment.items() if key not in preload}
    process = subprocess.Popen(
        tied(with_variables(command, preload)), env=without, start_new_session=True
    )

    def forward(number: int, _frame: Optional[FrameType]) -> None:
        process.send_signal(number)

    handlers = {number: signal.signal(number, forward) for number in _FORWARDED}
    try:
        return exit_status(process.wait(timeout))
    except subprocess.TimeoutExpired:
        return TIMED_OUT
    finally:
        stop_group(process)
        for number, handler in handlers.items():
            signal.signal(number, handler)
