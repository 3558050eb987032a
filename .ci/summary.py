#!/usr/bin/python3
"""Summarize JUnit results for a person; the last line counts: N passed, N failed, N skipped.

Exit code 1 if a test failed or none ran.
"""
import argparse
import sys
import xml.etree.ElementTree as ElementTree
from collections import namedtuple
from pathlib import Path

Case = namedtuple("Case", "suite name seconds verdict message")


def read_cases(path):
    """All test cases of a JUnit file, as Case tuples; a broken file counts as one failure."""
    try:
        root = ElementTree.parse(path).getroot()
    except ElementTree.ParseError as error:
        return [
            Case(path.parent.name, path.stem, 0.0, "failed", "results cannot be read: %s" % error)
        ]
    cases = []
    for case in root.iter("testcase"):
        problem = case.find("failure")
        problem = case.find("error") if problem is None else problem
        verdict = "passed"
        message = ""
        if problem is not None:
            verdict = "failed"
            message = problem.get("message") or (problem.text or "").strip()
        elif case.find("skipped") is not None or case.get("status") == "notrun":
            verdict = "skipped"
            skipped = case.find("skipped")
            message = "" if skipped is None else (skipped.get("message") or "")
        name = ".".join(part for part in (case.get("classname"), case.get("name")) if part)
        cases.append(Case(path.parent.name, name, float(case.get("time") or 0.0), verdict, message))
    return cases


def collect(folder):
    """Cases of all files below the folder.

    rostest writes each result twice (rostest-* sums up rosunit-*): the sum is read only for what
    no rosunit file has, such as a test node that died.
    """
    cases = []
    for package in sorted(path for path in folder.iterdir() if path.is_dir()):
        files = sorted(package.rglob("*.xml"))
        detailed = [
            case
            for path in files
            if not path.name.startswith("rostest-")
            for case in read_cases(path)
        ]
        known = {case.name.split(".")[-1] for case in detailed}
        sums = [
            case for path in files if path.name.startswith("rostest-") for case in read_cases(path)
        ]
        extra = [case for case in sums if case.name.split(".")[-1] not in known]
        cases += [case._replace(suite=package.name) for case in detailed + extra]
    return cases


def main():
    """Print the summary of a folder of results."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--seconds", type=float, help="wall time of the whole run, for the summary")
    arguments = parser.parse_args()
    cases = collect(arguments.folder)

    print("\n%-22s %8s %8s %8s %9s" % ("package", "passed", "failed", "skipped", "seconds"))
    for suite in sorted({case.suite for case in cases}):
        own = [case for case in cases if case.suite == suite]
        counts = [
            sum(case.verdict == verdict for case in own)
            for verdict in ("passed", "failed", "skipped")
        ]
        print("%-22s %8d %8d %8d %9.1f" % (suite, *counts, sum(case.seconds for case in own)))

    for case in (case for case in cases if case.verdict == "skipped"):
        print(
            "skipped: %s: %s%s"
            % (case.suite, case.name, ": " + case.message if case.message else "")
        )
    failed = [case for case in cases if case.verdict == "failed"]
    for case in failed:
        print("\nFAILED: %s: %s\n%s" % (case.suite, case.name, case.message[:3000]))
    if arguments.seconds:
        print("\n%.0f seconds in all" % arguments.seconds)
    passed = sum(case.verdict == "passed" for case in cases)
    skipped = sum(case.verdict == "skipped" for case in cases)
    print("%d passed, %d failed, %d skipped" % (passed, len(failed), skipped))
    return 1 if failed or not passed else 0


if __name__ == "__main__":
    sys.exit(main())
