"""Messages, services and actions, with the comments of their definitions."""
import re
from pathlib import Path
from typing import Any, Dict, Iterator, List, Tuple

import genmsg
import genmsg.msg_loader
from roslib.message import get_message_class, get_service_class

from mesh_tools_test.reference.markdown import code, page, plain, table

_KINDS = {
    "msg": ("Messages", ("",)),
    "srv": ("Services", ("Request", "Response")),
    "action": ("Actions", ("Goal", "Result", "Feedback")),
}
_NAME = re.compile(r"^\s*[\w/]+(?:\[\d*\])?\s+(\w+)\s*(?:=.*)?$")


def commented(text: str) -> Tuple[str, Dict[str, str]]:
    """What the comments say in a part of a definition: at its top, and of each name.

    A comment is that of the name on its line, else of the next line; one at the top that a line
    without anything follows is about the whole.
    """
    about, of_names, above = "", {}, []  # type: str, Dict[str, str], List[str]
    for line in text.splitlines():
        statement, _, comment = line.partition("#")
        name = _NAME.match(statement)
        if name:
            of_names[name.group(1)] = " ".join([*above, comment.strip()]).strip()
            above = []
        elif comment:
            above.append(comment.strip())
        else:
            if above and not about and not of_names:
                about = " ".join(above)
            above = []
    if not of_names and not about:
        about = " ".join(above)
    return about, of_names


def _part(title: str, text: str, name: str) -> str:
    spec = genmsg.msg_loader.load_msg_from_string(genmsg.MsgContext.create_default(), text, name)
    about, meanings = commented(text)
    fields = table(
        ("type", "field", "meaning"),
        [
            (code(field.type), code(field.name), plain(meanings.get(field.name, "")))
            for field in spec.parsed_fields()
        ],
    )
    constants = table(
        ("type", "constant", "value", "meaning"),
        [
            (code(one.type), code(one.name), code(str(one.val)), plain(meanings.get(one.name, "")))
            for one in spec.constants
        ],
    )
    nothing = "" if fields or constants else "Nothing."
    return page("**%s**" % title if title else "", plain(about), constants, fields, nothing)


def _class(kind: str, name: str) -> Any:
    if kind == "srv":
        return get_service_class(name)
    return get_message_class(name + ("Action" if kind == "action" else ""))


def _definition(package: str, path: Path) -> str:
    kind, name = path.suffix[1:], "%s/%s" % (package, path.stem)
    parts = re.split(r"^---.*$", path.read_text(encoding="utf-8"), flags=re.MULTILINE)
    titles = _KINDS[kind][1]
    if len(parts) != len(titles):
        raise ValueError("%s: %d parts instead of %d" % (path, len(parts), len(titles)))
    built = _class(kind, name)
    if built is None:
        raise ValueError("%s is not built: ./run build" % name)
    about = ""
    if kind != "msg":  # a comment right above the request is about the whole
        top = re.match(r"(?:#.*\n)+", parts[0])
        if top:
            about = plain(" ".join(line.strip("# ") for line in top.group().splitlines()))
            parts[0] = parts[0][top.end() :]
    return page(
        "### %s" % path.stem,
        about,
        "`%s`, md5 sum `%s`" % (name, built._md5sum),
        *(_part(title, text, name) for title, text in zip(titles, parts)),
    )


def definitions(folder: Path, kind: str) -> List[Path]:
    """The files of a kind ("msg", "srv", "action") of a package."""
    return sorted((folder / kind).glob("*." + kind))


def message_page(package: str, folder: Path) -> str:
    """The page of a package's messages, services and actions; "" where it has none.

    :raises ValueError: a definition that is not built.
    """

    def sections() -> Iterator[str]:
        for kind, (heading, _) in _KINDS.items():
            found = definitions(folder, kind)
            if found:
                yield "## " + heading
                yield from (_definition(package, path) for path in found)

    parts = list(sections())
    return page("# Messages of %s" % package, *parts) if parts else ""
