"""What of the repository is documented: its packages, by their names."""
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import Dict

ROOT = Path(__file__).resolve().parents[5]
_NO_CODE = {"build", "demo"}  # what ./run leaves
_OF_TESTS = ("test", "benchmark")  # packages within packages, which only their tests use


def packages() -> Dict[str, Path]:
    """Name -> folder of each package with a README, in alphabetical order."""
    found = {}
    for description in ROOT.glob("**/package.xml"):
        parts = description.relative_to(ROOT).parts[:-1]
        if _NO_CODE.intersection(parts[:1]) or set(_OF_TESTS).intersection(parts[1:]):
            continue
        if (description.parent / "README.md").is_file():
            name = ElementTree.parse(str(description)).findtext("name", "").strip()
            found[name] = description.parent
    return dict(sorted(found.items()))
