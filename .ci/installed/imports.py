#!/usr/bin/python3
"""Every module of our packages can be imported, and what it imports, at any time, comes from a
package that its own depends on."""
import ast
import functools
import importlib.util
import subprocess
import sys
from pathlib import Path

# Looked for, and done without: OpenCL; peers of benchmarks; what only the tests of others need.
OPTIONAL = {"hypothesis", "numba", "potpourri3d", "pygeodesic", "pyopencl"}


def lines(*command):
    """What a command prints."""
    return subprocess.run(
        command, stdout=subprocess.PIPE, universal_newlines=True, check=True
    ).stdout.splitlines()


def python_files(package):
    """Modules and scripts of Python in a Debian package, not what an example has to be copied."""
    for path in map(Path, lines("dpkg", "-L", package)):
        if path.suffix == ".py" and path.parts[:3] != ("/", "usr", "share"):
            yield path
        elif path.parts[:3] == ("/", "usr", "lib") and path.is_file() and not path.suffix:
            if path.read_bytes().startswith(b"#!/usr/bin/python3"):
                yield path


def imported(path):
    """The first names of what a file imports, wherever that stands in it."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name.partition(".")[0] for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            yield node.module.partition(".")[0]


@functools.lru_cache(maxsize=None)
def owner(module):
    """The Debian package that a module comes from; None of the standard library."""
    if module in sys.stdlib_module_names:
        return None
    spec = importlib.util.find_spec(module)
    if spec is None:
        return "(none: there is no module %s)" % module
    return lines("dpkg", "-S", spec.origin)[0].partition(":")[0]


@functools.lru_cache(maxsize=None)
def closure(package):
    """The packages that a package depends on, in turn, and itself."""
    options = ("recommends", "suggests", "conflicts", "breaks", "replaces", "enhances")
    words = ["--no-" + option for option in options]
    found = lines("apt-cache", "depends", "--recurse", "--installed", *words, package)
    return {line for line in found if not line.startswith((" ", "<"))}


def check(package):
    """Findings about the imports of a package."""
    modules = set()
    for path in python_files(package):
        for name in set(imported(path)) - OPTIONAL:
            wanted = owner(name)
            if wanted and wanted not in closure(package):
                yield "%s: %s imports %s of %s, on which it does not depend" % (
                    package,
                    path,
                    name,
                    wanted,
                )
        if path.suffix == ".py" and "dist-packages" in path.parts:
            parts = path.parts[path.parts.index("dist-packages") + 1 :]
            modules.add(".".join(parts)[: -len(".py")].replace(".__init__", ""))
    importing = "import importlib, sys\nfor name in sys.argv[1:]: importlib.import_module(name)"
    done = subprocess.run(
        [sys.executable, "-c", importing, *sorted(modules)], stderr=subprocess.PIPE, check=False
    )
    if done.returncode != 0:
        yield "%s: %s" % (package, done.stderr.decode().strip())
    print("%s: %d modules" % (package, len(modules)))


def main():
    """Exit code 1 if there is a finding."""
    ours = lines("dpkg-query", "-W", "-f=${Package} ${source:Package}\n")
    ours = [line.split()[0] for line in ours if line.endswith(" mesh-tools")]
    findings = [finding for package in ours for finding in check(package)]
    print("\n".join(findings))
    return 1 if findings or not ours else 0


if __name__ == "__main__":
    sys.exit(main())
