#!/usr/bin/python3
"""Installs the Debian packages in a bare Debian 12 and uses them there, as a user would.

The chroot is made by mmdebstrap once and unpacked anew for each run; what apt downloads is kept.
Each step runs in a mount namespace of its own, as a user without rights, and says how long it took.
"""
import argparse
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

INSTALLED = Path(__file__).resolve().parent / "installed"
APT = "DEBIAN_FRONTEND=noninteractive apt-get -q -y --no-install-recommends"
USER = 1000
# What a user does, in this order; scripts lie in installed/. The first two are the figure.
INSTALL = APT + " install mesh-tools"
DEMO = "rosrun mesh_tools_test demo --short --headless --output ~/demo"
STEPS = (
    ("demo to its picture", DEMO + " && ls ~/demo"),
    ("commands", "bash /check/commands.sh"),
    ("map server", "bash /check/map_server.sh"),
    ("imports of Python", "python3 /check/imports.py"),
    ("plugins in RViz", "python3 /check/rviz_plugins.py"),
)
DEVELOPMENT = APT + " install mesh-tools-dev"
OUTSIDE = ("a package outside", "bash /check/outside_package.sh")
# Mounts live as long as the command. Nothing but the check and the packages comes from outside.
ENTER = """
set -e
mount --make-rprivate /
mount --bind "$CHROOT" "$CHROOT"
mkdir -p "$CHROOT/check" "$CHROOT/packages" "$CHROOT/var/cache/apt/archives"
mount --bind "$CHECK" "$CHROOT/check"
mount --bind "$PACKAGES" "$CHROOT/packages"
mount --bind "$ARCHIVES" "$CHROOT/var/cache/apt/archives"
mount -t proc proc "$CHROOT/proc"
mount --rbind /dev "$CHROOT/dev"
exec chroot "$CHROOT" "$@"
"""


class CheckError(Exception):
    """A step failed; the text says which."""


class Chroot:
    """A bare Debian 12 in a folder, with a repository of the packages."""

    def __init__(self, work, packages):
        """
        :param work: folder for the chroot, its archive, and what apt downloads
        :param packages: folder of the .deb files
        """
        self._folder, self._archive = work / "chroot", work / "bookworm.tar"
        self._archives, self._packages = work / "archives", packages

    def make(self):
        """Unpack a bare system; the first time, make it."""
        (self._archives / "partial").mkdir(parents=True, exist_ok=True)
        if not self._archive.exists():
            made = self._archive.with_suffix(".new.tar")
            command = ["mmdebstrap", "--quiet", "--variant=minbase", "bookworm", str(made)]
            subprocess.run(command, check=True)
            made.rename(self._archive)
        shutil.rmtree(str(self._folder), ignore_errors=True)
        self._folder.mkdir(parents=True)
        subprocess.run(["tar", "-C", self._folder, "-xf", self._archive], check=True)
        with open(self._packages / "Packages", "wb") as index:
            command = ["dpkg-scanpackages", "--multiversion", "."]
            subprocess.run(
                command, cwd=self._packages, stdout=index, stderr=subprocess.DEVNULL, check=True
            )
        sources = self._folder / "etc/apt/sources.list.d/mesh-tools.list"
        sources.write_text("deb [trusted=yes] file:/packages ./\n")
        (self._folder / "etc/hosts").write_text("127.0.0.1 localhost\n")  # roslaunch asks for it
        # Nothing here has to survive a power cut. What apt has downloaded is kept.
        (self._folder / "etc/dpkg/dpkg.cfg.d/99unsafe").write_text("force-unsafe-io\n")
        (self._folder / "etc/apt/apt.conf.d/99keep").write_text(
            'APT::Keep-Downloaded-Packages "true";\nAPT::Sandbox::User "root";\n'
        )
        self.run("useradd --create-home --uid %d user" % USER, root=True)

    def run(self, text, root=False):
        """A command of bash in there; its output goes to ours.

        :raises CheckError: it failed
        """
        command = ["unshare", "--mount", "--pid", "--fork", "--kill-child", "sh", "-c", ENTER, "sh"]
        if not root:
            command += ["setpriv", "--reuid=%d" % USER, "--regid=%d" % USER, "--clear-groups"]
        home = "/root" if root else "/home/user"
        # no name of a machine needs to resolve
        environment = dict(PATH="/usr/sbin:/usr/bin:/sbin:/bin", HOME=home, ROS_IP="127.0.0.1")
        environment.update(LANG="C.UTF-8", CHROOT=str(self._folder), CHECK=str(INSTALLED))
        environment.update(PACKAGES=str(self._packages), ARCHIVES=str(self._archives))
        environment.update({name: os.environ[name] for name in PROXIES if name in os.environ})
        done = subprocess.run(
            [*command, "bash", "-e", "-c", "cd; " + text], env=environment, stdin=subprocess.DEVNULL
        )
        if done.returncode != 0:
            raise CheckError("failed with code %d: %s" % (done.returncode, text))


PROXIES = ("http_proxy", "https_proxy", "no_proxy")


def check(chroot, only, again):
    """All steps; returns (what, seconds) of each.

    :param only: names of steps, or none for all
    :param again: use what the last run installed
    """
    times = []

    def step(name, text, root=False):
        print("== " + name, flush=True)
        started = time.monotonic()
        chroot.run(text, root)
        times.append((name, time.monotonic() - started))
        print("== %s took %.1f s" % times[-1], flush=True)

    if not again:
        print("== bare Debian 12", flush=True)
        chroot.make()
        chroot.run("apt-get -q update && %s --download-only" % INSTALL, root=True)
        step("install", INSTALL, root=True)
    for name, text in STEPS:
        if not only or name in only:
            step(name, text)
    if not only or OUTSIDE[0] in only:
        chroot.run(DEVELOPMENT, root=True)
        step(*OUTSIDE)
    return times


def main():
    """Exit code 1 if a step failed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("packages", type=Path, help="folder of the .deb files")
    names = [name for name, _ in STEPS] + [OUTSIDE[0]]
    parser.add_argument("--only", action="append", choices=names, default=[])
    parser.add_argument("--again", action="store_true", help="use what the last run installed")
    options = parser.parse_args()
    if os.geteuid() != 0:  # for chroot, mounts and users
        as_root = ["sudo", "--preserve-env=" + ",".join(PROXIES), sys.executable, *sys.argv]
        return subprocess.run(as_root, check=False).returncode
    packages = options.packages.resolve()
    try:
        times = check(Chroot(packages.parent / "chroot", packages), options.only, options.again)
    except (CheckError, subprocess.CalledProcessError) as error:
        print("check_packages: %s" % error, file=sys.stderr)
        return 1
    for name, seconds in times:
        print("%-24s %6.1f s" % (name, seconds))
    if not (options.only or options.again):
        shown = sum(seconds for _, seconds in times[:2])
        print("%-24s %6.1f s" % ("from nothing to it shown", shown))
    return 0


if __name__ == "__main__":
    sys.exit(main())
