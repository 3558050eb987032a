"""What the commands of this package have in common."""

import argparse
import math
import sys
from typing import Any

from mesh_msgs_hdf5.commands.completion import bash_script

from mesh_msgs.text import one_line, read_more

TROUBLE = 2  # exit code: wrong usage, or what is needed is not there


class CommandParser(argparse.ArgumentParser):
    """A parser that complains in one line, has ``--completion``, and says where more is told."""

    def __init__(self, section: str, **arguments: Any) -> None:
        """
        Args:
            section: of the package's README.md that tells of the command: its anchor on the site.
            arguments: of argparse.
        """
        super().__init__(allow_abbrev=False, **arguments)
        self._section = section
        text = "print what makes bash complete these arguments, for .bashrc"
        self.add_argument("--completion", nargs=0, action=_Completion, help=text)

    def format_help(self) -> str:
        return f"{super().format_help()}\n{told_more(self._section)}"

    def error(self, message: str) -> None:
        complain(self.prog, f"{message} ({self.prog} --help)")
        sys.exit(TROUBLE)


class _Completion(argparse.Action):
    def __call__(self, parser: argparse.ArgumentParser, *_arguments: Any) -> None:
        sys.stdout.write(bash_script(parser.prog, "mesh_navigation", alone=False))
        sys.exit(0)


def told_more(section: str) -> str:
    """Where a section of the package's README.md is found, see `read_more`."""
    return read_more("mesh_navigation", f"packages/mesh_navigation.html#{section}")


def complete(parser: argparse.ArgumentParser) -> None:
    """Tell the shell what could come next, and end; without argcomplete: nothing."""
    try:
        import argcomplete
    except ImportError:
        sys.exit(1)
    argcomplete.autocomplete(parser, always_complete_options="long")


def is_number(word: str) -> bool:
    """Whether a word is a number, as those with a sign are that argparse takes for options."""
    try:
        float(word)
    except ValueError:
        return False
    return True


def number(text: str) -> float:
    """A type of arguments: a finite number."""
    value = float(text)
    if not math.isfinite(value):
        raise ValueError(text)
    return value


def told(program: str, text: str) -> str:
    """The line in which a command tells something."""
    return f"{program}: {one_line(text)}"


def tell(program: str, text: str) -> None:
    """One line on standard error."""
    sys.stderr.write(told(program, text) + "\n")


def complain(program: str, text: str) -> None:
    """The same of an error."""
    tell(program, f"error: {text}")
