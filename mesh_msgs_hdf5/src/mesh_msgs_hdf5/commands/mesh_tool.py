"""The command mesh_tool: reads its arguments, runs one verb, says what went wrong in one line.

Exit codes: 0 done, 1 it could not be done, 2 wrong usage. validate: 1 if a file has errors; diff: 1
if the meshes differ, 2 for trouble, as cmp and diff have it.
"""
import argparse
import difflib
import importlib
import os
import re
import sys
import traceback
from functools import partial
from typing import Callable, Dict, Iterable, List, NoReturn, Optional, Set, Tuple

from mesh_msgs.text import one_line, read_more
from mesh_msgs_hdf5.commands import ELSEWHERE, VERBS, command, completion
from mesh_msgs_hdf5.files.saved_files import SavedFiles
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.verbs.exported_verb import ExportedVerb

PROGRAM = "mesh_tool"
VERSION = "0.1.0"
_HELP = ("-h", "--help")
_SHOWN = 5  # of files that were saved
_NEGATIVE = re.compile(r"-\.?\d")  # no option begins so
_NAME = "--\0"  # stands for a -- that is a name; no argument has a NUL
_WORD = re.compile(r"[a-z][a-z0-9-]*")
_CODES = "exit codes: 0 done, 1 it could not be done, 2 wrong usage"


class _Parser(argparse.ArgumentParser):
    """Behind the first --, all is a name, also a --: Python's own takes more of them away. What
    looks like negative coordinates is a value: Python's own knows single negative numbers alone.
    The help of mesh_tool itself ends with where more is told."""

    def __init__(self, *arguments, **keywords):
        super().__init__(*arguments, **keywords)
        self._negative_number_matcher = _NEGATIVE  # whoever matches is no option

    def format_help(self):
        more = read_more("mesh_msgs_hdf5", "packages/mesh_msgs_hdf5.html#command-mesh-tool")
        return super().format_help() + ("\n" + more if self.prog == PROGRAM else "")

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


def make_parser(
    verbs: Iterable[str] = tuple(VERBS),
    exported: Iterable[ExportedVerb] = (),
    loaded: str = "",
) -> argparse.ArgumentParser:
    """The argument parser with a subparser for each of these verbs.

    exported: verbs of other packages, too, with their help alone; loaded: which of them with its
    arguments.
    """
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
    for one in exported:
        first, _, action = one.name.partition(" ")
        if not action:
            subparser = subparsers.add_parser(first, help=_escaped(one.help))
        elif first in subparsers.choices:
            inner = subparsers.choices[first]._actions
            below = next(each for each in inner if isinstance(each, argparse._SubParsersAction))
            subparser = below.add_parser(action, help=_escaped(one.help))
        else:
            continue
        if one.name == loaded:
            importlib.import_module(one.module).add_arguments(subparser)
    return parser


def _escaped(text: str) -> str:
    """A stranger's text as argparse takes it, who fills in %(prog)s and the like."""
    return text.replace("%", "%%")


def _actions(verb: str) -> Tuple[str, ...]:
    """The actions of a verb of ours; none where it has none, or is no verb."""
    return getattr(command(verb), "ACTIONS", ()) if verb in VERBS else ()


def _name_fault(name: str) -> str:
    """Why an exported verb cannot have a name; "" if it can."""
    first, _, action = name.partition(" ")
    if name in VERBS or action in _actions(first):
        return "mesh_tool has a verb of this name"
    if action and not _actions(first):
        return "mesh_tool has no verb %s with actions" % first
    return ""


def _exported(argv: List[str]) -> Tuple[Dict[str, ExportedVerb], List[str]]:
    """The verbs of other packages, and what is wrong with exports; none where all that can be meant
    is a verb of ours: looking for packages takes a moment.
    """
    first = argv[0] if argv else "--help"
    if first in VERBS:
        actions = _actions(first)
        words = [word for word in argv[1:2] if word in _HELP or _WORD.fullmatch(word)]
        is_ours = not actions or not words or words[0] in actions
    else:
        is_ours = first.startswith("-") and first not in _HELP
    if is_ours:
        return {}, []
    from mesh_msgs_hdf5.verbs.exported_verbs import exported_verbs

    return exported_verbs(_name_fault)


def _named(argv: List[str], names: Iterable[str]) -> str:
    """Which of these names of verbs the arguments begin with; "" for none."""
    known = set(names)
    return next((name for name in (" ".join(argv[:2]), *argv[:1]) if name in known), "")


def _run_elsewhere(verb: ExportedVerb, argv: List[str]) -> int:
    """Run a verb of another package."""
    from mesh_msgs_hdf5.verbs.verb_process import run_verb

    sys.stdout.flush()
    files = SavedFiles(argv)
    code, crash = run_verb(verb, argv[len(verb.name.split()) :])
    if crash:
        saved = files.since()
        hint = _saved(saved) if saved else "a file that it was to write is not there, or as before"
        _say("%s (%s)" % (crash, hint))
    return code


def run_exported(verb: List[str], argv: List[str], parent: int) -> int:
    """In a process of its own: run a verb of another package; returns the exit code.

    verb: the members of an ExportedVerb; parent: the process of mesh_tool.
    """
    from mesh_msgs_hdf5.verbs.verb_process import prepare_process

    prepare_process(parent)
    return run_here(verb, argv)


def run_here(verb: List[str], argv: List[str]) -> int:
    """Run a verb of another package in this process, as a command of its own; returns the exit
    code.

    verb: the members of an ExportedVerb.
    """
    _open_streams()
    _escape_in_streams()
    name, module, package, _ = verb
    what = "verb %s of package %s" % (name, package)

    def parse() -> argparse.Namespace:
        try:
            found = importlib.import_module(module)
            texts = found.HELP, "example: rosrun mesh_msgs_hdf5 " + found.EXAMPLE
            # argparse fills in those alone that have this
            text, example = (_escaped(t) if "%(prog)" in t else t for t in texts)
            parser = _Parser(prog="%s %s" % (PROGRAM, name), description=text, epilog=example)
            found.add_arguments(parser)
            parser.set_defaults(run=found.run, trouble=getattr(found, "TROUBLE", 1))
        except Exception as error:  # a stranger's code may bring out anything
            text = "%s cannot be loaded: %s: %s" % (what, type(error).__name__, error)
            _end(text + " (is the package built, and its workspace sourced?)", 1)
        return _parsed(parser, argv)

    try:
        return _guarded(parse, argv)
    except Exception as error:
        last = traceback.extract_tb(error.__traceback__)[-1]
        place = "%s, line %d" % (last.filename, last.lineno)
        _say("%s failed: %s: %s (%s)" % (what, type(error).__name__, error, place))
        return 1


def _end(text: str, code: int) -> NoReturn:
    _say(text)
    sys.exit(code)


def full_arguments(argv: List[str], exported: Iterable[str] = ()) -> List[str]:
    """The arguments with the action that is meant where a verb has some and none is given.

    exported: verbs of other packages, which may be actions.
    """
    verb = next((i for i, word in enumerate(argv) if not word.startswith("-")), None)
    if verb is None or argv[verb] not in VERBS:
        return argv
    actions = _actions(argv[verb])
    behind = argv[verb + 1 : verb + 2]
    if not actions or behind and behind[0] in (*actions, *_HELP):
        return argv
    if behind and len(argv) > verb + 2 and not os.path.exists(behind[0]):
        others = [name.partition(" ")[2] for name in exported if name.startswith(argv[verb] + " ")]
        _suggest("action", behind[0], [*actions, *others])
    return argv[: verb + 1] + [actions[0]] + argv[verb + 1 :]


def _suggest(what, word, known, always=False):
    """End with an error that names what is like the word, if anything is."""
    close = difflib.get_close_matches(word, known, 1, 0.6)
    if close or always:
        meant = "did you mean %s?" % close[0] if close else "there are: " + ", ".join(known)
        _say("there is no %s %r; %s (%s --help)" % (what, word, meant, PROGRAM))
        sys.exit(2)


def _verb(argv):
    return next((word for word in argv if not word.startswith("-")), None)


def _parse(argv):
    verb = _verb(argv)
    exported, problems = _exported(argv)
    name = _named(argv, exported)
    if name:
        run = partial(_run_elsewhere, exported[name])
        return argparse.Namespace(trouble=1, run=lambda _: run(argv))
    _say_problems(problems)
    missing = _named(argv, ELSEWHERE)
    if missing:
        text = "verb %s comes with package %s, which is not built, or its workspace is not sourced"
        _end(text % (missing, ELSEWHERE[missing]), 1)
    if verb is not None and verb not in VERBS:
        _suggest("verb", verb, [*VERBS, *exported], always=True)
    parser = make_parser([verb] if verb in VERBS else VERBS, exported.values())
    return _parsed(parser, full_arguments(argv, exported))


def _parsed(parser, argv):
    if "--" in argv or any(action.nargs == argparse.PARSER for action in parser._actions):
        arguments, rest = parser.parse_known_args(argv)
    else:  # options may be between the names of files
        arguments, rest = parser.parse_known_intermixed_args(argv)
    for word in rest:
        if word.startswith("-"):
            _suggest("option", word.split("=")[0], sorted(options_of(parser)))
    if rest:
        parser.error("unrecognized arguments: %s" % " ".join(rest))
    return arguments


def _say_problems(problems):
    for text in problems:
        print("%s: warning: %s" % (PROGRAM, one_line(text)), file=sys.stderr)


def _complete() -> NoReturn:
    """Tell the shell what could come next, and end the process."""
    argv = completion.words()
    exported, _ = _exported([*argv, "--help"])  # all that may come next is looked for
    verb, name = _verb(argv), _named(argv, exported)
    ours = [verb] if verb in VERBS else [] if name else VERBS
    try:
        completion.answer(make_parser(ours, exported.values(), name))
    except Exception:  # of a stranger's verb: there is nothing to offer
        sys.exit(1)


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


def _escape_in_streams():
    """What the locale has no characters for is escaped."""
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")


def main(argv: Optional[List[str]] = None) -> int:
    """Run the command; returns the exit code."""
    _open_streams()
    _escape_in_streams()
    if completion.wanted():
        _complete()
    argv = list(sys.argv[1:] if argv is None else argv)
    if argv:
        return _guarded(partial(_parse, argv), argv)
    exported, problems = _exported(argv)
    _say_problems(problems)
    make_parser(exported=exported.values()).print_help()
    return 2


def _saved(paths: List[str]) -> str:
    shown = ", ".join(paths[:_SHOWN])
    if len(paths) > _SHOWN:
        shown += ", and %d more files" % (len(paths) - _SHOWN)
    return "but saved already: " + shown


def _guarded(parse: Callable[[], argparse.Namespace], argv: List[str]) -> int:
    """Run what the arguments say; returns the exit code, and says in one line what went wrong."""
    trouble, files = 1, SavedFiles(argv)
    try:
        arguments = parse()
        trouble = arguments.trouble
        code = arguments.run(arguments)
        sys.stdout.flush()
        is_code = not isinstance(code, int) or 0 <= code < 256  # of others the system takes a part
        return code if is_code else 1
    except MapFileError as error:
        # who has an object may open it again, but not who has a verb
        if error.code == "changed":
            error.hint = "nothing was saved: run it again"
        _say(str(error))
    except MemoryError:
        _say("there is not enough memory for this mesh (use a machine with more)")
    except BrokenPipeError:  # the reader of our output has gone, as head does
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except OSError as error:  # what concerns the files is a MapFileError
        _say("cannot write the output: %s" % (error.strerror or error))
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except KeyboardInterrupt:
        saved = files.since()
        _say("interrupted, " + (_saved(saved) if saved else "nothing was saved"))
        return 130
    return trouble
