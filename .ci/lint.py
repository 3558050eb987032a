#!/usr/bin/python3
"""All linters and the rules of the house, offline; each finding names its correction.

Exit code 1 if there is a finding.
"""
import argparse
import os
import re
import shutil
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from xml.sax.saxutils import quoteattr

sys.dont_write_bytecode = True
import house_rules  # noqa: E402

ROOT = Path(__file__).resolve().parent.parent

# Runs a linter in Python that looks for garbage seldom: it is a quarter of what syntax trees cost.
HASTY = (
    "import gc, runpy, sys; gc.set_threshold(1000000); "
    "runpy.run_module(sys.argv.pop(1), run_name='__main__', alter_sys=True)"
)


def repository_files():
    """All files of the repository that git does not ignore, relative to its top."""
    listing = subprocess.run(
        ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        check=False,
    )
    if listing.returncode == 0:
        names = listing.stdout.decode().split("\0")
    else:  # an unpacked archive
        names = [path.relative_to(ROOT).as_posix() for path in ROOT.rglob("*")]
        names = [name for name in names if not name.startswith(("build/", "demo/", ".git/"))]
    return sorted(path for path in map(Path, set(names) - {""}) if (ROOT / path).is_file())


def is_python(path):
    """A .py file, or an executable without suffix that starts with Python's first line."""
    if path.suffix == ".py":
        return True
    if path.suffix:
        return False
    with open(ROOT / path, "rb") as stream:
        return stream.readline().startswith(b"#!/usr/bin/python3")


def command(tool, arguments, correction):
    """Run a linter; its output plus the correction, or '' if it is content."""
    if shutil.which(tool) is None:
        return "%s is not installed: ./run setup" % tool
    start = [sys.executable, "-c", HASTY, tool] if tool in ("black", "flake8") else [tool]
    result = subprocess.run(
        start + arguments, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False
    )
    return "" if result.returncode == 0 else result.stdout.decode() + "\n" + correction


def command_in_parts(tool, arguments, paths, correction):
    """The same for a linter that looks at one file after the other: a part of them on each core."""
    count = os.cpu_count() or 1
    parts = [paths[start::count] for start in range(min(count, len(paths)))]
    with ThreadPoolExecutor(count) as pool:
        findings = pool.map(lambda part: command(tool, arguments + part, correction), parts)
        return "\n".join(filter(None, findings))


def check_black(python):
    """What black would change; where it need not show anything it remembers what it has seen."""
    quick = ["--check", "--fast"]  # what is not written needs not be compared
    told = command("black", quick + python, "")
    differing = re.findall(r"^would reformat (.+)$", told, re.MULTILINE)
    if not differing:
        return told
    return command("black", quick + ["--quiet", "--diff"] + differing, "correct with: black FILE")


def timed(check):
    """(findings, seconds) of a check."""
    started = time.monotonic()
    return check(), time.monotonic() - started


def check_house_rules(files):
    """Findings of house_rules, one a line."""
    return "\n".join("%s:%s: %s" % finding for finding in house_rules.check(ROOT, files))


def main():
    """Run every check, print what they find, write JUnit results if asked."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--junit", type=Path, help="also write the results there")
    arguments = parser.parse_args()
    files = repository_files()
    python = [str(path) for path in files if is_python(path)]
    cpp = [str(path) for path in files if path.suffix in (".cpp", ".h")]
    packages = [str(folder) for folder in house_rules.package_folders(files)]
    checks = {
        "clang-format": lambda: command_in_parts(
            "clang-format", ["--dry-run", "--Werror"], cpp, "correct with: clang-format -i FILE"
        ),
        "black": lambda: check_black(python),
        "flake8": lambda: command("flake8", python, "correct as each line says"),
        "catkin_lint": lambda: command(
            "catkin_lint",
            ["-W2", "--strict", "--quiet", "--offline"] + packages,
            "correct as each line says",
        ),
        "house_rules": lambda: check_house_rules(files),
    }
    cases = []
    failed = 0
    pool = ThreadPoolExecutor(os.cpu_count() or 1)
    running = {name: pool.submit(timed, check) for name, check in checks.items()}
    for name, done in running.items():
        findings, seconds = done.result()
        print("%-14s %s" % (name, "ok" if not findings else "FINDINGS"))
        if findings:
            failed += 1
            print(findings)
        problem = "<failure message=%s/>" % quoteattr(findings) if findings else ""
        cases.append(
            '<testcase classname="lint" name="%s" time="%.2f">%s</testcase>'
            % (name, seconds, problem)
        )
    if arguments.junit:
        arguments.junit.parent.mkdir(parents=True, exist_ok=True)
        arguments.junit.write_text(
            '<testsuite name="lint" tests="%d" failures="%d">%s</testsuite>'
            % (len(cases), failed, "".join(cases)),
            encoding="utf-8",
        )
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
