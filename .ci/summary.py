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


def failure(path, message):
    """The case that stands for a whole file of results."""
    return Case(path.parent.name, path.stem, 0.0, "failed", message)


def read_cases(path, filtered=False):
    """All test cases of a JUnit file, as Case tuples.

    A file that is broken, has no case (but where they were filtered), or counts failures that no
    case tells of is a failure.
    """
    try:
        root = ElementTree.parse(path).getroot()
    except ElementTree.ParseError as error:
        return [failure(path, "results cannot be read: %s" % error)]
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
    counted = max(
        int(suite.get("failures") or 0) + int(suite.get("errors") or 0)
        for suite in [root] + list(root.iter("testsuite"))
    )
    if not cases and not filtered:
        cases.append(failure(path, "no test ran"))
    elif counted and not any(case.verdict == "failed" for case in cases):
        cases.append(failure(path, "%d failures are counted, but no test tells of them" % counted))
    return cases


def collect(folder, filtered=False):
    """Cases of all files below the folder.

    rostest writes rosunit-NAME.xml for each test node, and rostest-*.xml with one case testNAME for
    the node as a whole: that one is read only where the node left no results or ended otherwise.
    """
    cases = []
    for package in sorted(path for path in folder.iterdir() if path.is_dir()):
        nodes, own, told = [], [], set()
        for path in sorted(package.rglob("*.xml")):
            found = read_cases(path, filtered)
            if path.name.startswith("rostest-"):
                nodes += found
                continue
            own += found
            if path.name.startswith("rosunit-"):
                failed = any(case.verdict == "failed" for case in found)
                told.add(("test" + path.stem[len("rosunit-") :], failed))
        own += [c for c in nodes if (c.name.split(".")[-1], c.verdict == "failed") not in told]
        cases += [case._replace(suite=package.name) for case in own]
    return cases


def main():
    """Print the summary of a folder of results."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--seconds", type=float, help="wall time of the whole run, for the summary")
    parser.add_argument(
        "--filtered", action="store_true", help="programs may have had no test to run"
    )
    arguments = parser.parse_args()
    cases = collect(arguments.folder, arguments.filtered)

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
