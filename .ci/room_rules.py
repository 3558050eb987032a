"""Rules of the rooms inside the packages: their size, the arrows between them, and circles.

Which rooms there are, and their order, stands in rooms.py.
"""
import ast
import posixpath
import re
from collections import Counter

MAX_FILES = 25
CODE = (".py", ".cpp", ".h", ".cl")
GENERATED = re.compile(r"(msg|srv|action|cfg|_\w+)(\.|$)")  # modules that no file stands for
INCLUDE = re.compile(r"^\s*#\s*include\s*[<\"]([^>\"]+)[>\"]", re.MULTILINE)
TABLE = ".ci/rooms.py"


def check_folders(files):
    """Findings about folders that hold too many files of code."""
    counts = Counter(path.parent for path in files if path.suffix in CODE)
    for folder, count in sorted(counts.items()):
        if count > MAX_FILES:
            text = "%d files of code, more than %d: which rooms are in it?" % (count, MAX_FILES)
            yield folder.as_posix(), 0, text


def check_rooms(texts, packages, cpp, python):
    """Findings about the arrows between rooms and about circles of files.

    :param texts: path relative to the repository -> text, of all files of code
    :param packages: folders of packages
    :param cpp, python: package -> its rooms from top to bottom, see rooms.py
    """
    for folder in packages:
        rooms, modules = cpp_rooms(texts, folder), python_modules(texts, folder)
        arrows = {path: list(includes(texts, folder, path)) for path in rooms}
        yield from check_arrows(rooms, arrows, cpp.get(folder.name), folder.name, "CPP")
        for package in sorted({name.split(".")[0] for name in modules}):
            own = {name: path for name, path in modules.items() if name.split(".")[0] == package}
            arrows = {}
            for name, path in own.items():
                found, findings = imports(texts[path], name, path, own)
                arrows[path] = found
                yield from ((path.as_posix(), line, text) for line, text in findings)
            top = folder / "src" / package
            del arrows[top / "__init__.py"]  # it may use all
            rooms = {path: path.parent.relative_to(top).as_posix() for path in arrows}
            rooms = {path: "" if room == "." else room for path, room in rooms.items()}
            yield from check_arrows(rooms, arrows, python.get(package), package, "PYTHON")


def check_arrows(rooms, arrows, layers, package, table):
    """Findings about arrows; rooms: path -> room; arrows: path -> (line, path that it uses)."""
    if layers is None and set(rooms.values()) == {""}:
        layers = [{""}]
    order = {room: depth for depth, layer in enumerate(layers or []) for room in layer}
    for room in sorted(set(rooms.values()) - set(order)):
        path = min(path for path in rooms if rooms[path] == room)
        text = "which room is %r? add it to %s[%r] in %s" % (room, table, package, TABLE)
        yield path.parent.as_posix(), 0, text
    for path in sorted(arrows):
        for line, used in arrows[path]:
            room, other = rooms[path], rooms[used]
            if room == other or room not in order or other not in order:
                continue
            if order[other] > order[room]:
                continue
            beside = order[other] == order[room]
            text = "%s uses %s, from the room %r of the same layer" if beside else ""
            text = text or "%s uses %s, from the room %r above it"
            text += ": move one of them, pass in what is needed, or change " + TABLE
            yield path.as_posix(), line, text % (room or "the top", used.as_posix(), other)
    for circle in circles({path: [used for _, used in arrows[path]] for path in arrows}):
        names = " -> ".join(path.as_posix() for path in circle)
        text = "a circle of files: %s: one of them holds two concepts, or is in the wrong place"
        yield circle[0].as_posix(), 0, text % names


def cpp_rooms(texts, folder):
    """path -> room of the C++ files of a package."""
    found = {}
    for path in texts:
        if path.suffix not in (".cpp", ".h"):
            continue
        for root in (folder / "include" / folder.name, folder / "src"):
            if root in path.parents:
                room = path.parent.relative_to(root).as_posix()
                found[path] = "" if room == "." else room
                break
    return found


def includes(texts, folder, path):
    """(line, path) of the files of the same package that a C++ file includes."""
    for match in INCLUDE.finditer(texts[path]):
        name = match.group(1)
        places = [path.parent, folder / "src"]
        if name.startswith(folder.name + "/"):
            places.append(folder / "include")
        for place in places:
            used = type(path)(posixpath.normpath((place / name).as_posix()))
            if used in texts:
                inside = (folder / "src", folder / "include" / folder.name)
                if any(root in used.parents for root in inside):
                    yield texts[path].count("\n", 0, match.start(1)) + 1, used
                break


def python_modules(texts, folder):
    """dotted name -> path of the Python modules of a package."""
    found = {}
    source = folder / "src"
    for path in texts:
        if path.suffix != ".py" or source not in path.parents:
            continue
        parts = path.relative_to(source).with_suffix("").parts
        if len(parts) > 1 and source / parts[0] / "__init__.py" in texts:
            found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return found


def imports(text, name, path, modules):
    """What a Python module uses of its own package.

    :returns: list of (line, path), list of (line, finding)
    """
    package = name.split(".")[0]
    try:
        nodes = list(runtime_nodes(ast.parse(text)))
    except SyntaxError:  # is told elsewhere
        return [], []
    used, findings = [], []

    def use(line, module):
        if module in modules and module != name:
            used.append((line, modules[module]))
        elif module not in modules and not GENERATED.match(module[len(package) + 1 :]):
            findings.append((line, "no file for %s: import it from where it is now" % module))

    for node in nodes:
        if isinstance(node, ast.Import):
            for alias in node.names:
                if alias.name == package and name != package:
                    findings.append((node.lineno, "imports all of %s: import a module" % package))
                elif alias.name.split(".")[0] == package:
                    use(node.lineno, alias.name)
        elif isinstance(node, ast.ImportFrom):
            base = absolute(node, name, path)
            if base.split(".")[0] != package:
                continue
            for alias in node.names:
                module = base + "." + alias.name
                if module in modules or GENERATED.match(module[len(package) + 1 :]):
                    use(node.lineno, module)
                elif base == package and name != package:
                    text = "%s from the top of %s: import it from the module that defines it"
                    findings.append((node.lineno, text % (alias.name, package)))
                else:
                    use(node.lineno, base)
    return sorted(set(used)), findings


def absolute(node, name, path):
    """The dotted name of the module that `from ... import` names, relative or not."""
    if not node.level:
        return node.module or ""
    parts = name.split(".")
    keep = len(parts) - node.level + (path.name == "__init__.py")
    return ".".join(parts[:keep] + ([node.module] if node.module else []))


def runtime_nodes(tree):
    """All nodes of a syntax tree but those below `if TYPE_CHECKING`."""
    waiting = [tree]
    while waiting:
        node = waiting.pop()
        yield node
        test = getattr(node, "test", None)
        if isinstance(node, ast.If) and "TYPE_CHECKING" in (
            getattr(test, "id", ""),
            getattr(test, "attr", ""),
        ):
            waiting += node.orelse
        else:
            waiting += ast.iter_child_nodes(node)


def circles(graph):
    """Sets of nodes that lead to each other, and nodes that lead to themselves, sorted."""
    reached = {node: reachable(graph, node) for node in graph}
    found = set()
    for node, others in reached.items():
        if node in others:
            found.add(tuple(sorted(other for other in others if node in reached.get(other, ()))))
    return sorted(map(list, found))


def reachable(graph, start):
    """The nodes that a way of one step or more leads to."""
    found, waiting = set(), [start]
    while waiting:
        new = set(graph.get(waiting.pop(), ())) - found
        found |= new
        waiting += new
    return found
