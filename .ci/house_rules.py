"""The rules of the house that a program can check.

Each finding says where, what is wrong and the correction.
"""
import ast
import re

import release_rules
import room_rules
import rooms
import word_rules

# Which of our packages (and which outside ones that matter) a package's Python must not import.
NEVER_IMPORTED = {
    "mesh_msgs": ("h5py", "mesh_msgs_hdf5", "mesh_map", "mesh_navigation", "mesh_localization"),
    "mesh_msgs_hdf5": ("mesh_map", "mesh_navigation", "mesh_localization"),
    "mesh_map": ("h5py", "mesh_navigation", "mesh_localization", "rviz"),
    "mesh_localization": ("h5py", "mesh_navigation", "rviz"),
    "mesh_navigation": ("h5py", "mesh_localization", "rviz"),
    "mbf_mesh_nav": ("h5py", "rviz", "mesh_map"),
}
ROS_AT_THE_RIM = (
    "rospy",
    "rosbag",
    "actionlib",
    "tf2_ros",
    "dynamic_reconfigure",
    "message_filters",
)
RIM = re.compile(r"(^|/)(ros|tf2_support|\w+_node|\w+_ros)\.py$|/ros/\w+\.py$")
MAX_LINES, MAX_TEST_LINES = 700, 900
CODE = (".py", ".cpp", ".h", ".cl")
BANNED_CALLS = {
    "np.empty": "uninitialized arrays hide mistakes; use np.zeros or np.full",
    "numpy.empty": "uninitialized arrays hide mistakes; use numpy.zeros or numpy.full",
    "os.system": "no shell; use subprocess.run with a list",
    "eval": "never evaluate text",
    "exec": "never execute text",
    "pickle.load": "never load pickles; a file is untrusted input",
    "pickle.loads": "never load pickles; a message is untrusted input",
    "yaml.load": "use yaml.safe_load",
}
BANNED_CPP = (
    (
        re.compile(r"\bManualObject\b"),
        "Ogre::ManualObject sends whole meshes again; use a visual with hardware buffers",
    ),
    (
        re.compile(r"#include\s*[<\"](H5|hdf5|highfive)"),
        "only mesh_msgs_hdf5 opens HDF5, in Python",
    ),
    (re.compile(r"\bsystem\s*\("), "no shell; use QProcess"),
    (re.compile(r"\bexit\s*\("), "a library never ends its process; report an error"),
)
COMMAND_LINE = re.compile(r"(cli|commands?|mesh_tool)(/|\.py$)")
PAGES = ("docs/architecture.md", "CONTRIBUTING.md")
PATH_IN_PAGE = re.compile(r"`([\w./-]+/[\w./-]*|[\w-]+\.(?:py|cpp|h|cl|xml|json))`")
UNFINISHED = re.compile(r"\b(TO[D]O|FIX[M]E|XX[X])\b")


def dotted(node):
    """'np.empty' of the expression np.empty, '' if it is no plain name."""
    if isinstance(node, ast.Name):
        return node.id
    if isinstance(node, ast.Attribute):
        prefix = dotted(node.value)
        return prefix + "." + node.attr if prefix else ""
    return ""


def imported(node):
    """Top-level packages that an import statement names."""
    if isinstance(node, ast.Import):
        return [alias.name.split(".")[0] for alias in node.names]
    if isinstance(node, ast.ImportFrom) and node.level == 0:
        return [(node.module or "").split(".")[0]]
    return []


def check_python(path, text):
    """Findings in one Python file; path is relative to the top of the repository."""
    name = path.as_posix()
    try:
        tree = ast.parse(text, feature_version=(3, 8))
    except SyntaxError as error:
        yield name, error.lineno, f"not Python 3.8 ({error.msg}): Ubuntu 20.04 has no newer one"
        return
    library = "/src/" in name and "mesh_tools_test" not in name
    package = name.split("/src/")[1].split("/")[0] if library else ""
    for node in ast.walk(tree):
        if library:
            yield from (
                (name, node.lineno, finding) for finding in check_library(node, name, package)
            )
        if isinstance(node, ast.ExceptHandler) and node.type is None:
            yield name, node.lineno, "bare except: name the errors that are expected"
        if isinstance(node, ast.Call):
            call = dotted(node.func)
            if call in BANNED_CALLS and not (call.startswith("pickle") and "/test/" in name):
                yield name, node.lineno, f"{call}: {BANNED_CALLS[call]}"
            if any(key.arg == "shell" and getattr(key.value, "value", 0) for key in node.keywords):
                yield name, node.lineno, "shell=True: give the command as a list"
    if text.startswith("#!") and not text.startswith("#!/usr/bin/python3\n"):
        yield name, 1, "must start with #!/usr/bin/python3: another python3 on PATH has no rospy"


def check_library(node, name, package):
    """Findings in one syntax node of a package's library code."""
    for module in imported(node):
        if module in NEVER_IMPORTED.get(package, ()):
            yield f"{package} must not import {module}"
        if module in ROS_AT_THE_RIM and not RIM.search(name):
            yield f"{module} in a library: ROS stays in ros.py, *_ros.py, *_node.py and ros/"
    if isinstance(node, ast.Call):
        call = dotted(node.func)
        if call == "print" and not COMMAND_LINE.search(name):
            yield "print in a library: return the text, or log at the rim"
        if call == "h5py.File" and package != "mesh_msgs_hdf5":
            yield "only mesh_msgs_hdf5 opens HDF5: use its MapFile"


def check_cpp(path, text):
    """Findings in one C++ file."""
    name = path.as_posix()
    if "/test/" in name or name.startswith("test/"):
        return
    for number, line in enumerate(text.splitlines(), 1):
        code = line.split("//")[0]
        for pattern, correction in BANNED_CPP:
            if pattern.search(code):
                yield name, number, correction


def check_lengths(lengths):
    """Findings about file lengths; lengths maps paths to numbers of lines."""
    for path, lines in lengths.items():
        test = "test" in path.parts or path.name.startswith("test_")
        limit = MAX_TEST_LINES if test else MAX_LINES
        if lines > limit:
            yield path.as_posix(), lines, f"over {limit} lines: which second concept lives in it?"


def package_folders(files):
    """Folders of the packages that catkin finds: it never looks inside a package."""
    folders = {path.parent for path in files if path.name == "package.xml"}
    return sorted(folder for folder in folders if not folders & set(folder.parents))


def check_packages(root, files):
    """Each package has what ROS people expect beside its package.xml."""
    for folder in package_folders(files):
        for needed in ("README.md", "CHANGELOG.rst", "CMakeLists.txt"):
            if folder / needed not in files:
                yield folder.as_posix(), 0, f"a package needs a {needed}"
        if 'format="3"' not in (root / folder / "package.xml").read_text(encoding="utf-8"):
            yield folder.as_posix(), 0, "package.xml must be of format 3"


def check_paths(path, text, files):
    """Findings about files and folders that a page names as `code`, but that are not there."""
    whole = ["/%s/" % file.as_posix() for file in files]
    for number, line in enumerate(text.splitlines(), 1):
        for name in PATH_IN_PAGE.findall(line):
            if not name.startswith(("/", "./", "build/", "demo/")) and "..." not in name:
                if not any("/%s/" % name.strip("/") in file for file in whole):
                    yield path.as_posix(), number, f"no file or folder {name}: where is it now?"


def check(root, files):
    """All findings as (file, line, text) for the given files (paths relative to root)."""
    texts = {}
    for path in files:
        executable = (root / path).stat().st_mode & 0o100
        if path.suffix not in CODE and not executable:
            continue
        text = (root / path).read_text(encoding="utf-8", errors="replace")
        if path.suffix in CODE:
            texts[path] = text
            yield from word_rules.check(path, text)
        if path.suffix == ".py" or text.startswith("#!/usr/bin/python3"):
            yield from check_python(path, text)
        elif path.suffix in (".cpp", ".h"):
            yield from check_cpp(path, text)
        for number, line in enumerate(text.splitlines(), 1):
            if UNFINISHED.search(line):
                yield path.as_posix(), number, "unfinished: do it, or say it in the README"
    yield from word_rules.check_classes(texts)
    yield from check_lengths({path: text.count("\n") for path, text in texts.items()})
    yield from check_packages(root, set(files))
    for page in (path for path in files if path.as_posix() in PAGES):
        yield from check_paths(page, (root / page).read_text(encoding="utf-8"), files)
    yield from room_rules.check_folders(files)
    packages = package_folders(files)
    yield from room_rules.check_rooms(texts, packages, rooms.CPP, rooms.PYTHON)
    yield from release_rules.check(root, files, packages)
