"""The command mesh_tool: reads its arguments, runs one verb, says what went wrong in one line.

Exit codes: 0 done, 1 it could not be done, 2 wrong usage. validate: 1 if a file has errors; diff: 1
if the meshes differ, 2 for trouble, as cmp and diff have it.
"""
import argparse
import difflib
import os
import re
import sys
from typing import Iterable, List, Optional, Set

from mesh_msgs.text import one_line
from mesh_msgs_hdf5.commands import VERBS, command, completion
from mesh_msgs_hdf5.model.errors import MapFileError

PROGRAM = "mesh_tool"
VERSION = "0.1.0"
_HELP = ("-h", "--help")
_NAME = "--\0"  # stands for a -- that is a name; no argument has a NUL
_CODES = "exit codes: 0 done, 1 it could not be done, 2 wrong usage"


class _Parser(argparse.ArgumentParser):
    """Behind the first --, all is a name, also a --: Python's own takes more of them away."""

    def parse_known_args(self, args=None, namespace=None):
        words = list(sys.argv[1:] if args is None else args)
        if "--" in words:
            begin = words.index("--") + 1
            words[begin:] = [_NAME if word == "--" else word for word in words[begin:]]
        return super().parse_known_args(words, namespace)

    def _get_values(self, action, arg_strings):
        values = super()._get_values(action, arg_strings)
        if action.nargs == argparse.PARSER:  # for the parser of the verb
            return values
        if isinstance(values, list):
            return ["--" if value == _NAME else value for value in values]
        return "--" if values == _NAME else values

    def error(self, message):
        _say("%s (%s --help)" % (message, self.prog))
        sys.exit(2)


class _Completion(argparse.Action):
    """As other commands have it: the same as the verb completion."""

    def __call__(self, parser, *_arguments):
        sys.stdout.write(completion.bash_script())
        parser.exit()


def _say(text):
    print("%s: error: %s" % (PROGRAM, one_line(text)), file=sys.stderr)


def make_parser(verbs: Iterable[str] = tuple(VERBS)) -> argparse.ArgumentParser:
    """The argument parser with a subparser for each of these verbs."""
    parser = _Parser(
        prog=PROGRAM,
        description="Mesh maps in HDF5 files. Needs no roscore.",
        epilog=_CODES + ". mesh_tool VERB --help says more.",
    )
    text = "print what makes bash complete these arguments, for .bashrc"
    parser.add_argument("--completion", nargs=0, action=_Completion, help=text)
    parser.add_argument("--version", action="version", version="%s %s" % (PROGRAM, VERSION))
    subparsers = parser.add_subparsers(dest="verb", metavar="VERB", required=True)
    for verb in verbs:
        module = command(verb)
        subparser = subparsers.add_parser(
            verb,
            help=module.HELP,
            description=module.HELP,
            epilog="example: rosrun mesh_msgs_hdf5 " + module.EXAMPLE,
        )
        module.add_arguments(subparser)
        subparser.set_defaults(run=module.run, trouble=getattr(module, "TROUBLE", 1))
    return parser


def full_arguments(argv: List[str]) -> List[str]:
    """The arguments with the action that is meant where a verb has some and none is given."""
    verb = next((i for i, word in enumerate(argv) if not word.startswith("-")), None)
    if verb is None or argv[verb] not in VERBS:
        return argv
    actions = getattr(command(argv[verb]), "ACTIONS", ())
    behind = argv[verb + 1 : verb + 2]
    if not actions or behind and behind[0] in (*actions, *_HELP):
        return argv
    if behind and len(argv) > verb + 2 and not os.path.exists(behind[0]):
        _suggest("action", behind[0], actions)
    return argv[: verb + 1] + [actions[0]] + argv[verb + 1 :]


def _with_negative_values(argv):
    """--view -120,50 as --view=-120,50: argparse takes -120,50 for an option."""
    joined: List[str] = []
    for word in argv:
        option = joined[-1] if joined else ""
        if option.startswith("--") and "=" not in option and re.match(r"-[\d.]+,", word):
            joined[-1] = option + "=" + word
        else:
            joined.append(word)
    return joined


def _suggest(what, word, known, always=False):
    """End with an error that names what is like the word, if anything is."""
    close = difflib.get_close_matches(word, known, 1, 0.6)
    if close or always:
        meant = "did you mean %s?" % close[0] if close else "there are: " + ", ".join(known)
        _say("there is no %s %r; %s (%s --help)" % (what, word, meant, PROGRAM))
        sys.exit(2)


def _verb(argv):
    return next((word for word in argv if not word.startswith("-")), None)


def _parser_for(argv):
    """A parser that knows the verb alone, if there is one: the others need not be loaded."""
    verb = _verb(argv)
    return make_parser([verb] if verb in VERBS else VERBS)


def _parse(argv):
    verb = _verb(argv)
    if verb is not None and verb not in VERBS:
        _suggest("verb", verb, VERBS, always=True)
    parser = _parser_for(argv)
    arguments, rest = parser.parse_known_args(full_arguments(_with_negative_values(argv)))
    for word in rest:
        if word.startswith("-"):
            _suggest("option", word.split("=")[0], sorted(options_of(parser)))
    if rest:
        parser.error("unrecognized arguments: %s" % " ".join(rest))
    return arguments


def options_of(parser: argparse.ArgumentParser) -> Set[str]:
    """Every option of a parser and of the parsers of its verbs."""
    options = set()
    for action in parser._actions:
        options.update(action.option_strings)
        if isinstance(action.choices, dict):
            for below in action.choices.values():
                options |= options_of(below)
    return options


def _open_streams():
    """Open what is closed of standard input, output and error: else the next file, such as a map,
    would have that number, and what a library prints would go into it.
    """
    number = 0
    while number <= 2:
        number = os.open(os.devnull, os.O_RDWR)
        os.set_inheritable(number, number <= 2)
    os.close(number)
    for name, number in (("stdout", 1), ("stderr", 2)):
        if getattr(sys, name) is None:
            setattr(sys, name, open(number, "w", encoding="utf-8", closefd=False))


def main(argv: Optional[List[str]] = None) -> int:
    """Run the command; returns the exit code."""
    _open_streams()
    for stream in (sys.stdout, sys.stderr):  # what the locale has no characters for is escaped
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")
    trouble = 1
    if completion.wanted():
        completion.answer(_parser_for(completion.words()))
    argv = list(sys.argv[1:] if argv is None else argv)
    try:
        if not argv:
            make_parser().print_help()
            return 2
        arguments = _parse(argv)
        trouble = arguments.trouble
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
    return trouble
