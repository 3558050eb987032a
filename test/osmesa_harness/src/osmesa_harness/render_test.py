"""Runs one render test program on one back end, with a ROS master of its own."""

import argparse
import os
import signal
import sys
from typing import Dict, List, Optional

from osmesa_harness.back_ends import BackEnd, HeadlessError
from osmesa_harness.headless import run_headless
from osmesa_harness.results import has_ended_tests, label_results, progress_file


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="render_test",
        description="Runs a render test, as osmesa_harness_add_render_test says.",
    )
    parser.add_argument("--back-end", required=True, choices=[end.value for end in BackEnd])
    parser.add_argument("--results", required=True, metavar="XML", help="JUnit XML to write")
    parser.add_argument("--label", required=True, help="prefix of the suites' names in there")
    parser.add_argument("--out", required=True, metavar="FOLDER", help="where pictures go")
    parser.add_argument("--reference", metavar="FOLDER", help="pictures of an earlier run")
    parser.add_argument("--timeout", type=float, default=600.0, metavar="SECONDS")
    parser.add_argument("--no-preload", action="store_true", help="the shim is linked")
    parser.add_argument("--env", action="append", default=[], metavar="NAME=VALUE")
    parser.add_argument("program")
    parser.add_argument("arguments", nargs=argparse.REMAINDER)
    return parser


def _remove_old(results: str, pictures: str) -> None:
    # What an earlier run left must not be taken for this one's.
    for path in (results, progress_file(results)):
        if os.path.exists(path):
            os.remove(path)
    os.makedirs(os.path.dirname(os.path.abspath(results)), exist_ok=True)
    os.makedirs(pictures, exist_ok=True)
    for name in os.listdir(pictures):
        if name.endswith(".png"):
            os.remove(os.path.join(pictures, name))


def _environment(options: argparse.Namespace, back_end: BackEnd) -> Dict[str, str]:
    environment = dict(os.environ)
    environment["OSMESA_HARNESS_OUT"] = options.out
    environment["OSMESA_HARNESS_PROGRESS"] = progress_file(options.results)
    environment["OSMESA_HARNESS_EXPECT_OSMESA"] = "0" if back_end is BackEnd.XVFB else "1"
    environment.pop("OSMESA_HARNESS_REFERENCE", None)
    if options.reference:
        environment["OSMESA_HARNESS_REFERENCE"] = options.reference
    for setting in options.env:
        name, equals, value = setting.partition("=")
        if not name or not equals:
            raise HeadlessError(f"--env {setting}: expected NAME=VALUE")
        environment[name] = value
    return environment


def _broke_in_first_frames(back_end: BackEnd, status: int, results: str) -> bool:
    """Mesa's GLX clears a buffer that it has freed, now and then, in the first frames of RViz.

    Seen 6 times in 2,200 runs on a busy machine, on Xvfb alone, also without a plugin of ours and
    without threads of the rasterizer; what it overwrites takes RViz with it.
    """
    memory = [128 + number for number in (signal.SIGSEGV, signal.SIGBUS, signal.SIGABRT)]
    return back_end is BackEnd.XVFB and status in memory and not has_ended_tests(results)


def main(arguments: Optional[List[str]] = None) -> int:
    """The command `render_test`; returns its exit status."""
    options = _parser().parse_args(arguments)
    back_end = BackEnd(options.back_end)
    _remove_old(options.results, options.out)
    command = [options.program, f"--gtest_output=xml:{options.results}", *options.arguments]
    try:
        environment = _environment(options, back_end)
        preload = not options.no_preload
        status = run_headless(command, back_end, True, options.timeout, environment, preload)
        if _broke_in_first_frames(back_end, status, options.results):
            sys.stderr.write(
                f"render_test: signal {status - 128} in the first test on Xvfb, which Mesa's GLX "
                "does now and then; once more\n"
            )
            _remove_old(options.results, options.out)
            status = run_headless(command, back_end, True, options.timeout, environment, preload)
    except (HeadlessError, RuntimeError) as error:
        sys.stderr.write(f"render_test: {error}\n")
        status = 1
    program = os.path.basename(options.program)
    label_results(options.results, options.label, program, status, options.timeout)
    return status
