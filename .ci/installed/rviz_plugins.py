#!/usr/bin/python3
"""RViz itself, without a screen, loads all classes that our two packages of plugins describe."""
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from xml.etree import ElementTree

import rospkg
import yaml

PACKAGES = ("rviz_mesh_plugin", "rviz_map_plugin")
LIBRARY = "librviz_mesh_plugin_displays.so"
SECTIONS = {"rviz::Display": "Displays", "rviz::Tool": "Tools", "rviz::Panel": "Panels"}
PATIENCE = 60.0  # seconds until RViz has loaded all


def described():
    """(base class, name) of all plugins that are described."""
    for package in PACKAGES:
        path = Path(rospkg.RosPack().get_path(package)) / "plugin_description.xml"
        for each in ElementTree.parse(path).getroot().iter("class"):
            yield each.get("base_class_type"), each.get("name")


def configuration(classes):
    """RViz's configuration with one of each."""
    sections = {"Displays": [], "Tools": [], "Panels": []}
    for base, name in classes:
        sections[SECTIONS[base]].append({"Class": name, "Name": name, "Enabled": True})
    manager = {"Displays": sections["Displays"], "Tools": sections["Tools"]}
    manager["Global Options"] = {"Fixed Frame": "map"}
    return {"Panels": sections["Panels"], "Visualization Manager": manager}


def mapped_libraries():
    """The libraries that any process here has mapped; the harness gives RViz a group of its own."""
    mapped = set()
    for maps in Path("/proc").glob("[0-9]*/maps"):
        try:
            mapped.update(Path(line.split()[-1]).name for line in maps.read_text().splitlines())
        except OSError:  # it has ended, or is another user's
            continue
    return mapped


def main():
    """Exit code 1 if a class was not loaded."""
    classes = list(described())
    folder = Path(tempfile.mkdtemp())
    (folder / "all.rviz").write_text(yaml.safe_dump(configuration(classes)))
    log = folder / "rviz.log"
    rviz = ["rosrun", "osmesa_harness", "headless", "--master", "--timeout", str(PATIENCE)]
    rviz += ["rviz", "-d", str(folder / "all.rviz")]
    with open(log, "wb") as stream:
        child = subprocess.Popen(rviz, stdout=stream, stderr=stream, start_new_session=True)
    end = time.monotonic() + PATIENCE - 5.0
    loaded = False
    while not loaded and child.poll() is None and time.monotonic() < end:
        time.sleep(0.5)
        loaded = LIBRARY in mapped_libraries()
    time.sleep(5.0)  # tools and panels come after the first display
    alive = child.poll() is None
    child.terminate()
    child.wait()
    text = log.read_text(errors="replace")
    failures = [line for line in text.splitlines() if "failed to load" in line]
    if failures or not loaded or not alive:
        print(text)
        print("RViz %s, %s %s" % ("lives" if alive else "died", LIBRARY, "loaded" * loaded))
        return 1
    print("RViz has loaded %d displays, tools and panels" % len(classes))
    return 0


if __name__ == "__main__":
    sys.exit(main())
