"""Completion of a command's arguments in bash, through argcomplete: of mesh_tool and its like.

The shell calls the command itself (a variable of the environment says that it does), which answers
with what could come next: verbs, options, choices, and names that are in the map file at hand.
"""
import argparse
import os
import re
import shlex
import sys
from typing import Any, List, Sequence

from mesh_msgs_hdf5.model.errors import MapFileError

_VARIABLE = "_ARGCOMPLETE"  # which of the shell's words is the command, from 1

_BASH = """# completion for %(program)s behind rosrun %(package)s
_%(function)s_words() {
    local IFS=$'\\013'
    COMPREPLY=($(IFS="$IFS" COMP_LINE="$COMP_LINE" COMP_POINT="$COMP_POINT" \\
        COMP_TYPE="$COMP_TYPE" _ARGCOMPLETE_COMP_WORDBREAKS="$COMP_WORDBREAKS" \\
        _ARGCOMPLETE="$1" _ARGCOMPLETE_SHELL=bash _ARGCOMPLETE_SUPPRESS_SPACE=1 \\
        %(executable)s 8>&1 9>/dev/null 1>/dev/null 2>/dev/null))
    if [[ $? != 0 ]]; then
        COMPREPLY=()
    elif [[ ${#COMPREPLY[@]} == 1 && ${COMPREPLY[0]} =~ [=/:]$ ]]; then
        compopt -o nospace
    fi
}
_%(function)s_rosrun() {
    if [[ $COMP_CWORD -gt 2 && ${COMP_WORDS[1]} == %(package)s \\
          && ${COMP_WORDS[2]} == %(program)s ]]; then
        compopt -o default
        _%(function)s_words 3
    elif declare -F "$_%(function)s_rosrun_before" >/dev/null; then
        "$_%(function)s_rosrun_before" "$@"
    fi
}
if [[ -z ${_%(function)s_rosrun_before:-} ]]; then
    _%(function)s_rosrun_before=$(complete -p rosrun 2>/dev/null \\
        | sed -n 's/.*-F \\([^ ]*\\).*/\\1/p')
    _%(function)s_rosrun_before=${_%(function)s_rosrun_before//\\"/}
    _%(function)s_rosrun_before=${_%(function)s_rosrun_before:-_roscomplete_exe}
fi
complete -F _%(function)s_rosrun rosrun
"""
# and on its own
_ON_ITS_OWN = """_%(function)s() { _%(function)s_words 1; }
complete -o default -F _%(function)s %(program)s
"""
_FILES = ("file", "files", "input", "one", "other", "origin", "clouds", "images")
# options that name a part -> what may name the file that has it
_PARTS = {
    "part": ("file", "input", "one", "files"),
    "other_part": ("other",),
    "from_part": ("origin", "input"),
    "to_part": ("output",),
}
_UNQUOTED = re.compile(r"\\.|[#~?\[\]{}]", re.DOTALL)
_SUFFIXES = ("h5", "hdf5", "ply", "obj", "stl", "off", "dae", "zae", "fbx", "3ds")
_SUFFIXES += ("glb", "gltf", "json", "csv")
_SUFFIXES += ("pcd", "png", "jpg", "jpeg")


def bash_script(
    program: str = "mesh_tool", package: str = "mesh_msgs_hdf5", alone: bool = True
) -> str:
    """What bash has to evaluate so that it completes the arguments of this command.

    program, package: behind which words of rosrun. alone: whether the program on its own is meant,
    too.
    """
    names = {
        "program": program,
        "package": package,
        "function": program if alone else "%s_%s" % (package, program),
        "executable": shlex.quote(os.path.realpath(sys.argv[0])),
    }
    return (_BASH + _ON_ITS_OWN if alone else _BASH) % names


def wanted() -> bool:
    """True if the shell asks for what could come next."""
    return _VARIABLE in os.environ


def words() -> List[str]:
    """The words behind the command in the line that is completed, as far as they are whole."""
    line = os.environ.get("COMP_LINE", "")[: int(os.environ.get("COMP_POINT", "0"))]
    before = line.split()[int(os.environ[_VARIABLE]) :]
    return before if line[-1:].isspace() else before[:-1]


def answer(parser: argparse.ArgumentParser) -> None:
    """Tell the shell what could come next, and end the process; without argcomplete: nothing."""
    try:
        import argcomplete
    except ImportError:
        sys.exit(1)

    class Finder(argcomplete.CompletionFinder):
        """Quotes also what it leaves to bash: comments, homes, patterns and braces."""

        def quote_completions(self, completions, cword_prequote, last_wordbreak_pos):
            quoted = super().quote_completions(completions, cword_prequote, last_wordbreak_pos)
            if cword_prequote:
                return quoted
            return [_UNQUOTED.sub(_quoted, word) for word in quoted]

    _set_completers(parser, argcomplete.FilesCompleter(_SUFFIXES))
    Finder()(parser, always_complete_options="long")


def _quoted(match):
    return match[0] if match[0].startswith("\\") else "\\" + match[0]


def _set_completers(parser, files):
    """Give the arguments that are files, or names in a map file, what completes them."""
    kind = next(
        (kind for kind in ("label", "part", "scan") if " %ss " % kind in parser.prog), "layer"
    )
    for action in parser._actions:
        if isinstance(action.choices, dict):
            for below in action.choices.values():
                _set_completers(below, files)
        elif action.dest in _FILES and action.type is None:
            action.completer = files
        elif action.dest in _PARTS:
            action.completer = _Names("part", _PARTS[action.dest])
        elif action.dest == "view":
            action.completer = _views
        elif action.nargs != 0 and action.dest in _NAMES_OF:
            action.completer = _Names("face" if action.dest == "face" else kind)


def _views(**_others: Any) -> List[str]:
    from mesh_msgs_hdf5.rendering.render_camera import VIEWS

    return list(VIEWS)


_NAMES_OF = ("layer", "face", "name", "names", "old", "scan", "scans")


class _Names:
    """Completes names of one kind from the file that was named before."""

    def __init__(self, kind: str, files: Sequence[str] = ("origin", "file", "input")) -> None:
        """files: the arguments of which the first that is given names the file."""
        self._kind, self._files = kind, files

    def __call__(self, prefix: str, parsed_args: argparse.Namespace, **others: Any) -> List[str]:
        # in this process: it ends right after, however hostile the file is
        from mesh_msgs_hdf5.map_file import MapFile
        from mesh_msgs_hdf5.map_file.map_file import parts_of
        from mesh_msgs_hdf5.map_file.scans import ScanFile

        given = vars(parsed_args)
        path = next((given[name] for name in self._files if given.get(name)), None)
        kind = given.get("place") or self._kind
        path = path[0] if isinstance(path, list) else path
        if not path:
            return []
        try:
            if kind == "scan":
                return ScanFile(path).names()
            if kind == "part":
                return [part or "/" for part in parts_of(path)]
            file = MapFile(path, given.get("part"))
            if kind == "label":
                return file.label_names()
            if kind == "vertex":
                return file.vertex_attribute_names()
            return file.face_attribute_names() if kind == "face" else file.layer_names()
        except MapFileError:  # there is no name to offer
            return []


NAME = "completion"
HELP = "print what makes bash complete mesh_tool's arguments; see the example for .bashrc"
EXAMPLE = 'mesh_tool completion bash  (in .bashrc: eval "$(rosrun ...)")'


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("shell", choices=("bash",))


def run(arguments: argparse.Namespace) -> int:
    print(bash_script(), end="")
    return 0
