"""Names of one word for each concept, and of one concept for each word.

Words of our own are refused in the names of files, classes, functions and members where the field
has a word for the same thing; so is a class of Python that has the name of another one. See the
glossary in docs/architecture.md.
"""
import ast
import re

# The word -> the field's word. Names that users meet (FIELD_NAMES) stay.
BANNED = {
    "anchor": "face point",
    "anchors": "face points",
    "asker": "client",
    "cancelled": "canceled (as in actionlib and Move Base Flex)",
    "desk": "client",
    "feed": "sources",
    "front": "fast marching, or queue",
    "fronts": "fast marching",
    "grounds": "snapshots",
    "inbox": "queue",
    "news": "changes",
    "painter": "appearance",
    "painters": "appearances",
    "spread": "propagation",
    "standing": "surface pose",
    "way": "path, or direction",
    "ways": "paths, or directions",
}
# What is documented, or belongs to a library.
FIELD_NAMES = re.compile(
    r"\bQPainter\w*|\b(?:\w+_)?front\(|[Ww]ave_?[Ff]ront|\bSurfaceFront\b|\bWAVE_FRONT|\bway_from\b"
)
# Both of them are documented.
TWINS = ("MeshController", "MeshGeometry")
CPP_TEXT = re.compile(
    r'R"\((?:.|\n)*?\)"|/\*(?:.|\n)*?\*/|//[^\n]*|"(?:\\.|[^"\\\n])*"|#\s*include[^\n]*'
)
CPP_NAME = re.compile(r"\b(?:[A-Z]\w*[a-z]\w*|[a-z]\w*_\b|[a-z]\w*(?=\())")
WORDS = re.compile(r"[A-Z]?[a-z0-9]+|[A-Z0-9]+(?![a-z])")


def words_of(name):
    """['fast', 'marching', 'queue'] of FastMarchingQueue and of fast_marching_queue_."""
    return [word.lower() for word in WORDS.findall(name)]


def python_names(text):
    """(line, name) of each class, function and member that a Python file defines."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, (ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)):
            yield node.lineno, node.name
        if isinstance(node, ast.ClassDef):
            for field in node.body:
                if isinstance(field, ast.AnnAssign) and isinstance(field.target, ast.Name):
                    yield field.lineno, field.target.id
        elif isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store):
            yield node.lineno, node.attr


def cpp_names(text):
    """(line, name) of what may be a class, a function or a member in a C++ file."""
    text = CPP_TEXT.sub(lambda match: "\n" * match.group().count("\n"), text)
    for number, line in enumerate(FIELD_NAMES.sub("", text).splitlines(), 1):
        for name in CPP_NAME.findall(line):
            yield number, name


def check(path, text):
    """Findings in the names of one file of a product (tests tell stories in theirs)."""
    name = path.as_posix()
    if "test" in path.parts:
        return
    found = [(0, path.stem)]
    found += python_names(text) if path.suffix == ".py" else cpp_names(text)
    for line, whole in found:
        for word in words_of(FIELD_NAMES.sub("", whole)):
            if word in BANNED:
                yield name, line, f"{whole}: the field's word for {word!r} is {BANNED[word]}"


def check_classes(texts):
    """Findings about public classes of Python whose name another one has; texts: path -> text."""
    first = {}
    for path, text in sorted(texts.items()):
        if path.suffix != ".py" or "test" in path.parts:
            continue
        for node in ast.parse(text).body:
            if isinstance(node, ast.ClassDef) and node.name[0] != "_" and node.name not in TWINS:
                other = first.setdefault(node.name, path.as_posix())
                if other != path.as_posix():
                    where = "another class of this name is in %s: one name, one concept" % other
                    yield path.as_posix(), node.lineno, f"{node.name}: {where}"
