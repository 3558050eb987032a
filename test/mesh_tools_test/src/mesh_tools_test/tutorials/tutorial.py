"""What a tutorial's page says is done, in the order of the page.

A page is Markdown as MyST reads it (the site is built by the same parser). What counts:

* a fence `bash`: commands that are typed into the terminal;
* a fence `python`: a program that is typed into Python there;
* a directive `{code-block} LANGUAGE` with a caption: a file of that name; with a caption `NAME
  terminal`: commands that are typed into another terminal, where they stay in the foreground (a
  node that runs until the end of the page);
* a fence `text`: each of its lines is in what the commands before it have printed, where `…` stands
  for anything;
* a comment `% run: COMMAND`: a command that a reader need not see (what he looks at, waits for, or
  sees in RViz); `% type NAME: COMMAND`: one in another terminal.

Other fences are shown alone.
"""
import re
from pathlib import Path
from typing import List, NamedTuple, Set

from markdown_it.renderer import RendererHTML
from myst_parser.config.main import MdParserConfig
from myst_parser.parsers.mdit import create_md_parser

MAIN = ""  # the terminal that a page begins with
PICTURES = "pictures/"  # where pages look for the pictures that their runs make
_HIDDEN = re.compile(r"\s*(?:run|type (?P<terminal>\w+)): *(?P<command>.+)")
_CAPTION = ":caption:"
_TERMINAL = re.compile(r"(.+) terminal$", re.IGNORECASE)


class TutorialError(Exception):
    """A page that cannot be read, or does not do what it says; names the page and the line."""


class Step(NamedTuple):
    """One thing that a reader does, or sees.

    kind: run, type (into another terminal), write (a file), see (in the last output)
    name: of the terminal or the file
    """

    line: int
    kind: str
    text: str
    name: str = MAIN


class Tutorial(NamedTuple):
    """A page: its steps, and the names of the pictures that it shows of its run."""

    path: Path
    steps: List[Step]
    pictures: Set[str]


def _tokens(text):
    parser = create_md_parser(MdParserConfig(enable_extensions=["colon_fence"]), RendererHTML)
    return parser.parse(text)


def _options(content):
    """The caption of a directive, and what stands below its options."""
    caption, lines = "", content.splitlines(keepends=True)
    while lines and lines[0].startswith(":"):
        line = lines.pop(0)
        if line.startswith(_CAPTION):
            caption = line[len(_CAPTION) :].strip()
    if lines and not lines[0].strip():
        lines.pop(0)
    return caption, "".join(lines)


def _python(program):
    return "/usr/bin/python3 - <<'END_OF_PYTHON'\n%sEND_OF_PYTHON\n" % program


def _of_directive(line, language, content):
    """The step of a code-block, None for one that is only shown."""
    caption, text = _options(content)
    if not caption:
        return _of_fence(line, language, text)
    terminal = _TERMINAL.match(caption)
    if terminal:
        return Step(line, "type", text, terminal.group(1))
    return Step(line, "write", text, caption)


def _of_fence(line, language, text):
    if language == "bash":
        return Step(line, "run", text)
    if language == "python":
        return Step(line, "run", _python(text))
    if language == "text":
        return Step(line, "see", text)
    return None


def _steps(token):
    line = token.map[0] + 1 if token.map else 0
    if token.type == "myst_line_comment":
        for offset, comment in enumerate(token.content.splitlines()):
            hidden = _HIDDEN.match(comment)
            if hidden:
                command, terminal = hidden.group("command") + "\n", hidden.group("terminal")
                kind = "type" if terminal else "run"
                yield Step(line + offset, kind, command, terminal or MAIN)
    elif token.type == "fence":
        directive = re.match(r"\{code-block\}\s*(\w+)", token.info)
        if directive:
            step = _of_directive(line, directive.group(1), token.content)
        else:
            step = _of_fence(line, token.info.strip(), token.content)
        if step:
            yield step


def _images(tokens):
    for token in tokens:
        if token.type == "image":
            yield str(token.attrs.get("src", ""))
        elif token.type == "fence" and re.match(r"\{(figure|image)\}", token.info):
            yield token.info.split("}", 1)[1].strip()
        yield from _images(token.children or [])


def read_tutorial(path: Path) -> Tutorial:
    """The page in a file."""
    tokens = _tokens(path.read_text(encoding="utf-8"))
    steps = [step for token in tokens for step in _steps(token)]
    shown = {name.split(PICTURES, 1)[1] for name in _images(tokens) if PICTURES in name}
    return Tutorial(path, steps, shown)


def line_pattern(line: str) -> "re.Pattern[str]":
    """What a shown line of output stands for: `…` for anything, blanks for any blanks."""
    parts = [
        r"\s+".join(re.escape(word) for word in re.split(r"\s+", part)) for part in line.split("…")
    ]
    return re.compile(".*".join(parts))
