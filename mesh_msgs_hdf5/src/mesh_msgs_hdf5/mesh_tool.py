"""The command mesh_tool: reads its arguments, runs one verb, says what went wrong in one line.

Exit codes: 0 done, 1 it could not be done, 2 wrong usage.
"""
import argparse
import os
import sys
from typing import List, Optional

from mesh_msgs_hdf5.commands import import_mesh, info
from mesh_msgs_hdf5.errors import MapFileError, one_line

COMMANDS = (import_mesh, info)
PROGRAM = "mesh_tool"


class _Parser(argparse.ArgumentParser):
    def error(self, message):
        _say("%s (%s --help)" % (message, self.prog))
        sys.exit(2)


def _say(text):
    print("%s: error: %s" % (PROGRAM, one_line(text)), file=sys.stderr)


def make_parser() -> argparse.ArgumentParser:
    """The argument parser with a subparser for each verb."""
    parser = _Parser(
        prog=PROGRAM,
        description="Mesh maps in HDF5 files. Needs no roscore.",
        epilog="exit codes: 0 done, 1 it could not be done, 2 wrong usage",
    )
    verbs = parser.add_subparsers(dest="verb", metavar="VERB", required=True)
    for command in COMMANDS:
        verb = verbs.add_parser(
            command.NAME,
            help=command.HELP,
            description=command.HELP,
            epilog="example: rosrun mesh_msgs_hdf5 " + command.EXAMPLE,
        )
        command.add_arguments(verb)
        verb.set_defaults(run=command.run)
    return parser


def main(argv: Optional[List[str]] = None) -> int:
    """Run the command; returns the exit code."""
    arguments = make_parser().parse_args(argv)
    try:
        code = arguments.run(arguments)
        sys.stdout.flush()
        return code
    except MapFileError as error:
        _say(str(error))
    except MemoryError:
        _say("there is not enough memory for this mesh (use a machine with more)")
    except BrokenPipeError:  # the reader of our output has gone, as head does
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except OSError as error:  # what concerns the files is a MapFileError
        _say("cannot write the output: %s" % (error.strerror or error))
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except KeyboardInterrupt:
        _say("interrupted, nothing was saved")
        return 130
    return 1
