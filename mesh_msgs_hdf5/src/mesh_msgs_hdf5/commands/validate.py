"""mesh_tool validate: what is wrong or odd about mesh files."""
import argparse
import sys

from mesh_msgs.text import one_line
from mesh_msgs_hdf5.commands._common import add_output_options, add_part, say
from mesh_msgs_hdf5.commands.progress import ProgressLine
from mesh_msgs_hdf5.validation.findings import ERROR, NOTE, RULES, WARNING, counts
from mesh_msgs_hdf5.validation.validate import validate

NAME = "validate"
HELP = "say all that is wrong or odd about mesh files (exit code 1 if a file has errors)"
EXAMPLE = "mesh_tool validate --strict --ignore components garden.h5"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("files", metavar="FILE", nargs="+", help="a map file, or any mesh")
    text = "warnings are errors; notes are not"
    parser.add_argument("--strict", action="store_true", help=text)
    parser.add_argument(
        "--ignore",
        metavar="RULE",
        action="append",
        default=[],
        choices=sorted(RULES),
        help="leave out findings of this rule; may be given several times (--rules lists them)",
    )
    parser.add_argument("--rules", action=_Rules, help="list the rules and exit")
    add_part(parser, "map files with several")
    add_output_options(parser, "say nothing: the exit code tells")


class _Rules(argparse.Action):
    def __init__(self, **keywords):
        super().__init__(nargs=0, **keywords)

    def __call__(self, parser, *others):
        for rule, meaning in RULES.items():
            print("%-28s %s" % (rule, meaning))
        parser.exit()


def run(arguments: argparse.Namespace) -> int:
    results = []
    with ProgressLine(arguments.quiet) as progress:
        for path in arguments.files:
            name = one_line(path)
            findings = validate(
                path, arguments.part, lambda s, n=name: progress.stage(n + ": " + s)
            )
            results.append((path, _judged(findings, arguments)))
    valid = not any(finding.level == ERROR for _, found in results for finding in found)
    report = {
        "valid": valid,
        "files": [
            {"path": path, "counts": counts(found), "findings": [f._asdict() for f in found]}
            for path, found in results
        ],
    }
    say(arguments, report, _lines(results))
    sys.stdout.flush()
    return 0 if valid else 1


def _judged(findings, arguments):
    found = [finding for finding in findings if finding.rule not in arguments.ignore]
    if arguments.strict:
        found = [f._replace(level=ERROR) if f.level == WARNING else f for f in found]
    return found


def _lines(results):
    for path, found in results:
        for finding in found:
            yield "%s: %s" % (path, finding.line())
        number = counts(found)
        parts = [
            "%d %s%s" % (number[level], level, "" if number[level] == 1 else "s")
            for level in (ERROR, WARNING, NOTE)
            if number[level]
        ]
        verdict = "not valid" if number[ERROR] else "valid"
        yield "%s: %s%s" % (path, verdict, ", " + ", ".join(parts) if parts else "")
