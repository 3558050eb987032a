"""Modules under the names that they had before they moved."""
import importlib
import importlib.util
import pickle
import subprocess
import sys
import textwrap
from unittest import mock

import pytest

from mesh_msgs.module_aliases import alias_modules

FILES = {
    "house/__init__.py": "",
    "house/upstairs/__init__.py": "WHERE = 'upstairs'",
    "house/upstairs/bed.py": """
        import sys
        LOADED = getattr(sys, "times_the_bed_was_loaded", 0) + 1
        sys.times_the_bed_was_loaded = LOADED
        class Pillow:
            pass
        def sleep():
            return snore()
        def snore():
            return "z"
        """,
    "house/upstairs/needy.py": "import a_module_that_nobody_has",
    "house/upstairs/broken.py": "1 / 0",
    "house/upstairs/desk/__init__.py": "from house.upstairs.desk import drawer",
    "house/upstairs/desk/drawer.py": "PENS = []",
    "user_of_the_house.py": """
        import house.bed
        import house.bed as short
        from house import bed
        from house.bed import Pillow, snore as noise
        whole = house.bed
        """,
    "wants_too_much.py": "from house.bed import blanket",
    "asks_for_gone.py": "from house import gone",
    "asks_for_moved_out.py": "from house import moved_out",
}
ALIASES = {
    "house.bed": "house.upstairs.bed",
    "house.needy": "house.upstairs.needy",
    "house.broken": "house.upstairs.broken",
    "house.gone": "house.upstairs.gone",
    "house.moved_out": "garden.shed",
    "house.table": "house.upstairs.desk",
    "house.bunk": "house.bed",
}


@pytest.fixture(autouse=True)
def house(tmp_path, monkeypatch):
    """A package with modules that moved; forgotten afterwards."""
    for name, text in FILES.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(textwrap.dedent(text))
    monkeypatch.syspath_prepend(str(tmp_path))
    alias_modules(ALIASES)
    yield tmp_path
    forgotten = {name.split("/")[0].replace(".py", "") for name in FILES}
    for name in [name for name in sys.modules if name.split(".")[0] in forgotten]:
        del sys.modules[name]
    if hasattr(sys, "times_the_bed_was_loaded"):
        del sys.times_the_bed_was_loaded


def both():
    return importlib.import_module("house.bed"), importlib.import_module("house.upstairs.bed")


def test_the_old_name_is_the_real_module():
    old, new = both()
    assert old is new is sys.modules["house.bed"] is sys.modules["house.upstairs.bed"]
    assert new.LOADED == 1


def test_the_new_name_first():
    new = importlib.import_module("house.upstairs.bed")
    assert importlib.import_module("house.bed") is new and new.LOADED == 1


def test_the_real_module_keeps_what_import_says_of_it():
    old, _ = both()
    assert old.__name__ == old.__spec__.name == "house.upstairs.bed"
    assert old.__package__ == "house.upstairs"
    assert old.__loader__ is old.__spec__.loader
    assert old.__file__.endswith("bed.py")
    assert importlib.reload(old) is old and old.LOADED == 2


def test_forms_of_import():
    user = importlib.import_module("user_of_the_house")
    _, new = both()
    assert user.whole is user.bed is user.short is new is sys.modules["house"].bed
    assert user.Pillow is new.Pillow and user.noise is new.snore
    with pytest.raises(ImportError, match="cannot import name 'blanket'"):
        importlib.import_module("wants_too_much")


def test_nothing_is_loaded_before_somebody_asks():
    importlib.import_module("house")
    assert not [name for name in sys.modules if name.startswith("house.")]
    assert importlib.util.find_spec("house.bed").origin == "house.upstairs.bed"
    assert "house.upstairs.bed" not in sys.modules


def test_patching_by_the_old_name():
    with mock.patch("house.bed.snore", return_value="loud"):
        assert importlib.import_module("house.upstairs.bed").sleep() == "loud"
    assert importlib.import_module("house.upstairs.bed").sleep() == "z"


def test_pickles_carry_the_real_name_and_those_of_before_are_read():
    old, new = both()
    stored = pickle.dumps(old.Pillow(), protocol=0)
    assert b"house.upstairs.bed" in stored
    assert type(pickle.loads(stored)) is new.Pillow
    before = stored.replace(b"house.upstairs.bed", b"house.bed")
    assert type(pickle.loads(before)) is new.Pillow


def test_what_is_below_a_package_that_moved():
    drawer = importlib.import_module("house.table.drawer")
    assert drawer is importlib.import_module("house.upstairs.desk.drawer")
    assert importlib.import_module("house.table").drawer is drawer
    with pytest.raises(
        ImportError, match="house.upstairs.desk.lamp, which .* house.table.lamp now"
    ):
        importlib.import_module("house.table.lamp")


def test_a_name_that_moved_twice():
    assert importlib.import_module("house.bunk") is importlib.import_module("house.upstairs.bed")


@pytest.mark.parametrize("name", ["house.gone", "house.moved_out"])
def test_a_module_that_is_not_there_is_named_with_both_names(name):
    for asked in (name, name.replace("house.", "asks_for_")):
        with pytest.raises(ImportError) as error:
            importlib.import_module(asked)
        assert name in str(error.value) and ALIASES[name] in str(error.value)
        assert error.value.name == name
    assert name not in sys.modules


def test_other_errors_stay_what_they_are():
    with pytest.raises(ModuleNotFoundError) as error:
        importlib.import_module("house.needy")
    assert error.value.name == "a_module_that_nobody_has"
    with pytest.raises(ZeroDivisionError):
        importlib.import_module("house.broken")
    assert "house.broken" not in sys.modules
    with pytest.raises(ModuleNotFoundError, match="No module named 'house.cellar'"):
        importlib.import_module("house.cellar")


def test_one_finder_however_often_it_is_called():
    finders = list(sys.meta_path)
    alias_modules({"house.lair": "house.upstairs.bed"})
    alias_modules(ALIASES)
    assert sys.meta_path == finders
    assert importlib.import_module("house.lair") is importlib.import_module("house.bed")


@pytest.mark.parametrize("new", ["house.bed", "house.bed.frame"])
def test_a_module_cannot_move_below_itself(new):
    with pytest.raises(ValueError, match="house.bed would be found below itself"):
        alias_modules({"house.bed": new})
    assert importlib.import_module("house.bed").LOADED == 1


def test_a_fresh_interpreter(house):
    code = (
        "from mesh_msgs.module_aliases import alias_modules\n"
        "alias_modules({'house.bed': 'house.upstairs.bed'})\n"
        "import house, threading\n"
        "def load(): import house.bed\n"
        "threads = [threading.Thread(target=load) for _ in range(8)]\n"
        "[thread.start() for thread in threads], [thread.join() for thread in threads]\n"
        "assert house.bed.LOADED == 1 and house.bed is house.upstairs.bed\n"
    )
    subprocess.run([sys.executable, "-W", "error", "-c", code], check=True, cwd=str(house))
