"""RViz on a screen of its own, and the hands of its user."""
import os
import subprocess
import time
from contextlib import contextmanager
from pathlib import Path
from typing import Optional

import numpy as np
from PIL import Image, ImageGrab

from mesh_tools_test.demo.processes import wait_until
from mesh_tools_test.screen.widgets import Box, Widgets, packed


def wait_for(condition, seconds):
    """What the condition returns as soon as it is true; else what it returned last."""
    end = time.monotonic() + seconds
    value = condition()
    while not value and time.monotonic() < end:
        time.sleep(0.1)
        value = condition()
    return value


def has_ended(pid):
    """Whether there is no such process, or only its entry."""
    try:
        status = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return True
    return status.rpartition(")")[2].split()[0] == "Z"


class Screen:
    """RViz as its user sees and handles it.

    :param child: (name, process, log file) of RViz
    :param folder: where the shim leaves what 3D views show
    :param shows: whether a picture of a 3D view shows what it should
    :param widgets: those that RViz was given the style sheet of
    """

    def __init__(self, child, folder, environment, shows, widgets: Optional[Widgets] = None):
        self.child, self.folder, self.environment = child, folder, environment
        self.shows, self.widgets = shows, widgets
        self._seen = {}  # name -> where it was last

    def do(self, *arguments):
        """What xdotool prints."""
        command = ["xdotool", *map(str, arguments)]
        return subprocess.run(
            command,
            env=self.environment,
            check=True,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
        ).stdout.decode()

    def try_to(self, *arguments):
        """What xdotool prints; empty where it fails."""
        try:
            return self.do(*arguments)
        except subprocess.CalledProcessError:
            return ""

    def pictures(self):
        """What the 3D views show, the newest of each."""
        for path in self.folder.glob("frame-*.ppm"):
            with Image.open(str(path)) as image:
                yield np.asarray(image.convert("RGB"))

    def picture(self):
        """What the screen shows, but for 3D views."""
        return ImageGrab.grab(xdisplay=self.environment["DISPLAY"]).convert("RGBA")

    def find_now(self, name):
        """Where a widget is, None where it is not there or cannot be used."""
        return self.widgets.box(packed(self.picture()), name)

    @contextmanager
    def kept_after_failure(self):
        """A picture of the screen, where the test run keeps pictures, if something fails."""
        try:
            yield self
        except Exception:
            kept = os.environ.get("OSMESA_HARNESS_OUT")
            if kept and self.child[1].poll() is None:
                self.picture().save(Path(kept) / f"{self.folder.name}.png")
            raise

    def drag(self, begin, end):
        """With the left button."""
        self.drag_along([begin, [(a + b) // 2 for a, b in zip(begin, end)], end])

    def drag_along(self, path, key=None):
        """With the left button, and a key that is held."""
        self.do("mousemove", *path[0], *(["keydown", key] if key else []), "mousedown", 1)
        for at in path[1:]:
            self.do("sleep", 0.2, "mousemove", *at)
        self.do("sleep", 0.2, "mouseup", 1, *(["keyup", key] if key else []))

    def find(self, name, seconds=60.0) -> Box:
        """Where a widget is, once it is there, can be used, and stays where it is.

        :raises DemoError: after that time
        """
        places = [self._seen.get(name)]

        def stays():
            places.append(self.find_now(name))
            return places[-1] is not None and places[-1] == places[-2]

        wait_until(stays, seconds, f"a '{name}' that can be used", [self.child])
        self._seen[name] = places[-1]
        return places[-1]

    def rows(self, *names):
        """Where those are that have one of these names and stand one below the other."""
        picture = packed(self.picture())
        pieces = [self.widgets.pieces(picture, name) for name in names]
        return sorted(sum(pieces, []), key=lambda piece: piece.top)

    def is_there(self, name):
        """Whether a widget is there and can be used."""
        return self.find_now(name) is not None

    def wait_gone(self, name):
        """Until a widget is not there any more, or cannot be used."""
        wait_until(lambda: not self.is_there(name), 60.0, f"the end of '{name}'", [self.child])

    def click(self, name):
        """Left, in the middle of a widget."""
        self.do("mousemove", *self.find(name).middle, "sleep", 0.05, "click", 1)

    def click_away(self, name):
        """A button that closes its dialog; again where the first click has only closed a popup."""

        def gone():
            if self.is_there(name):
                self.click(name)
            return wait_for(lambda: not self.is_there(name), 5.0)

        self.find(name)
        wait_until(gone, 60.0, f"the end of '{name}'", [self.child])

    def type(self, text):
        """Instead of what is in the field that has the keys."""
        self.do("sleep", 0.1, "key", "ctrl+a", "key", "BackSpace")
        if text:
            self.do("type", "--delay", 15, text)

    def fill(self, name, text):
        """A field."""
        self.click(name)
        self.type(text)

    def choose(self, name, index):
        """An entry of a combo box, by its number."""
        self.click(name)
        self.find("popup")
        self.do("key", "Home", *["key", "Down"] * index, "key", "Return")
        self.wait_gone("popup")

    def choose_in_menu(self, name, key):
        """An entry of the menu of a button, by its key."""
        self.click(name)
        self.find("menu")
        self.do("key", key)
        self.wait_gone("menu")

    def middle(self):
        """Column and row of the middle of the 3D view, once it shows what it should."""

        def found():
            shapes = [p.shape[:2] for p in self.pictures() if self.shows(p)]
            windows = self.try_to("search", "--maxdepth", 12, "--class", "") if shapes else ""
            for window in windows.split():
                lines = self.try_to("getwindowgeometry", "--shell", window).split()
                values = dict(line.split("=") for line in lines)
                left, top, width, height = [
                    int(values.get(name, 0)) for name in ("X", "Y", "WIDTH", "HEIGHT")
                ]
                if (height, width) in shapes:
                    return np.array([left + 0.5 * width, top + 0.5 * height])
            return None

        place = []
        wait_until(
            lambda: place.append(found()) or place[-1] is not None,
            100,
            "a view of the map",
            [self.child],
        )
        return place[-1]

    def pid(self):
        """Of RViz itself."""
        return int(self.do("search", "--onlyvisible", "--class", "rviz", "getwindowpid").split()[0])
