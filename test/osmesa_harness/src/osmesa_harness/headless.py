"""Runs one program without a screen, with a ROS master of its own if wanted."""

import argparse
import contextlib
import os
import shutil
import sys
from typing import List, Mapping, Optional, Sequence

from osmesa_harness.back_ends import BackEnd, HeadlessError, environment_of
from osmesa_harness.master import private_master
from osmesa_harness.processes import TIMED_OUT, run

_USAGE_ERROR = 2
_NOT_FOUND = 127


def run_headless(
    command: Sequence[str],
    back_end: BackEnd = BackEnd.OSMESA,
    master: bool = False,
    timeout: Optional[float] = None,
    environment: Optional[Mapping[str, str]] = None,
    preload: bool = True,
) -> int:
    """Runs `command` to its end and returns its exit status (124: stopped after `timeout` seconds).

    `environment` is the present one by default. Without `preload` the program must link the shim
    itself. Raises HeadlessError: one line on what is missing.
    """
    if shutil.which(command[0]) is None:
        raise HeadlessError(f"no program {command[0]}: give a path or a name on PATH")
    with contextlib.ExitStack() as stack:
        changed = stack.enter_context(
            environment_of(back_end, os.environ if environment is None else environment, preload)
        )
        if master:
            changed = stack.enter_context(private_master(changed))
        return run(command, changed, timeout)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="headless",
        usage="%(prog)s [-h] [--x | --x-osmesa] [--master] [--no-preload] [--timeout SECONDS] "
        "CMD ...",
        description="Runs CMD without a screen: drawn by OSMesa, with no X server at all.",
        epilog="OSMESA_GLX_DUMP=PREFIX writes each window to PREFIX-<id>.ppm, at most twice a "
        "second. The exit status is that of CMD; 124: time limit; 127: no such program.",
    )
    where = parser.add_mutually_exclusive_group()
    where.add_argument("--x", action="store_true", help="on a private Xvfb, drawn by its own GLX")
    where.add_argument("--x-osmesa", action="store_true", help="on a private Xvfb, drawn by OSMesa")
    parser.add_argument("--master", action="store_true", help="with a private ROS master")
    parser.add_argument(
        "--no-preload", action="store_true", help="CMD has libosmesa_glx.so linked (sanitizers)"
    )
    parser.add_argument("--timeout", type=float, metavar="SECONDS", help="end CMD after this time")
    parser.add_argument("command", nargs=argparse.REMAINDER, metavar="CMD ...", help="what to run")
    return parser


def main(arguments: Optional[List[str]] = None) -> int:
    """The command `headless`; returns its exit status."""
    parser = _parser()
    options = parser.parse_args(arguments)
    command = options.command[1:] if options.command[:1] == ["--"] else options.command
    if not command:
        parser.print_usage(sys.stderr)
        return _USAGE_ERROR
    back_end = BackEnd.OSMESA
    if options.x or options.x_osmesa:
        back_end = BackEnd.XVFB if options.x else BackEnd.OSMESA_X
    try:
        preload = not options.no_preload
        status = run_headless(command, back_end, options.master, options.timeout, preload=preload)
    except (HeadlessError, RuntimeError) as error:
        sys.stderr.write(f"headless: {error}\n")
        return _NOT_FOUND
    if status == TIMED_OUT and options.timeout is not None:
        sys.stderr.write(f"headless: {command[0]} ended after {options.timeout:g} s\n")
    return status
