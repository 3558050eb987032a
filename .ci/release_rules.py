"""What a release needs: one version everywhere, and Debian packages of all packages.

The version is that of package.xml, which catkin_prepare_release raises in all packages at once.
"""
import re
from xml.etree import ElementTree

CONTROL, CHANGELOG = "debian/control", "debian/changelog"
IN_PYTHON = re.compile(r'^(?:__version__|VERSION) = "([^"]*)"', re.MULTILINE)
IN_CHANGELOG = re.compile(r"\A\S+ \(([^)]*)\)")
SECTION = re.compile(r"^(.+)\n-{3,}$", re.MULTILINE)
TITLE = re.compile(r"Forthcoming|\d+\.\d+\.\d+ \(\d{4}-\d{2}-\d{2}\)")
RUN_TIME = ("depend", "exec_depend")


def debian_name(package):
    """The Debian package of a catkin package."""
    return "ros-" + package.replace("_", "-")


def manifests(root, folders):
    """Name -> (file, root element of package.xml) of the packages in these folders."""
    found = {}
    for folder in folders:
        path = folder / "package.xml"
        element = ElementTree.fromstring((root / path).read_text(encoding="utf-8"))
        found[element.findtext("name", "").strip()] = path, element
    return found


def stanzas(text):
    """Package -> {field: value} of debian/control; that of the source has the name ''."""
    found = {}
    for part in re.split(r"\n\s*\n", text.strip()):
        pairs = re.findall(r"^([\w-]+):((?:.*)(?:\n[ \t].*)*)", part, re.MULTILINE)
        fields = {name: value.strip() for name, value in pairs}
        found[fields.get("Package", "")] = fields
    return found


def check_versions(root, files, packages):
    """Findings about versions that are not the one of the first package.

    :param packages: as of manifests()
    """
    versions = {path: each.findtext("version", "").strip() for path, each in packages.values()}
    first = next(iter(versions), None)
    wanted = versions.get(first)
    correction = f"is not {wanted}, the version in {first}: all packages are released together"
    for path, version in versions.items():
        if version != wanted:
            yield path.as_posix(), 0, f"version {version} {correction}"
    for path in sorted(files):
        if path.as_posix() == CHANGELOG:
            pattern = IN_CHANGELOG
        elif path.suffix == ".py" and "src" in path.parts and "test" not in path.parts[1:]:
            pattern = IN_PYTHON
        else:
            continue
        for version in pattern.findall((root / path).read_text(encoding="utf-8")):
            if version != wanted:
                yield path.as_posix(), 0, f"version {version} {correction}"


def check_changelogs(root, packages):
    """Findings about CHANGELOG.rst, whose sections bloom reads."""
    for path, _ in packages.values():
        changelog = path.parent / "CHANGELOG.rst"
        titles = SECTION.findall((root / changelog).read_text(encoding="utf-8"))
        if not titles:
            yield changelog.as_posix(), 0, "no section: Forthcoming, or VERSION (YYYY-MM-DD)"
        for title in titles:
            if not TITLE.fullmatch(title):
                yield changelog.as_posix(), 0, f"{title}: no Forthcoming or VERSION (YYYY-MM-DD)"


def check_control(text, packages):
    """Findings about debian/control: what is missing of our packages, and of their dependencies."""
    found = stanzas(text)
    names = {debian_name(package): package for package in packages}
    for name in sorted(set(names) - set(found)):
        yield CONTROL, 0, f"there is no Package {name}, of the catkin package {names[name]}"
    for name in sorted(set(found) - set(names)):
        if name.startswith("ros-"):
            yield CONTROL, 0, f"{name}: there is no such catkin package"
    for name in sorted(set(names) & set(found)):
        words = [word.strip() for word in found[name].get("Depends", "").split(",")]
        _, manifest = packages[names[name]]
        keys = {each.text.strip() for tag in RUN_TIME for each in manifest.findall(tag)}
        for key in sorted(keys & set(packages)):
            wanted = debian_name(key) + " (= ${binary:Version})"
            if wanted not in words:
                yield CONTROL, 0, f"{name}: Depends lacks {wanted}, as package.xml has {key}"
    everything = found.get("mesh-tools", {}).get("Depends", "")
    for name in sorted(set(names)):
        if f"{name} (= " not in everything:
            yield CONTROL, 0, f"mesh-tools: Depends lacks {name}"


def check(root, files, folders):
    """All findings as (file, line, text).

    :param folders: of the packages that catkin finds
    """
    packages = manifests(root, folders)
    yield from check_versions(root, files, packages)
    yield from check_changelogs(root, packages)
    yield from check_control((root / CONTROL).read_text(encoding="utf-8"), packages)
