"""Modules under the names that they had before they moved, for code that imports those."""
import importlib
import sys
from importlib.machinery import ModuleSpec


def alias_modules(names):
    """Let modules be imported by the keys of `names`, too; its values say where they are now.

    For a package's __init__.py: alias_modules({"mesh_map.queries": "mesh_map.map.queries"}).
    Whoever imports an old name gets the one real module, which is loaded only then. What is below
    a package that moved is found below its new name.
    """
    circle = [old for old, new in names.items() if (new + ".").startswith(old + ".")]
    if circle:
        raise ValueError("%s would be found below itself" % circle[0])
    _ALIASES.new_names.update(names)
    if _ALIASES not in sys.meta_path:
        # in front: of the folder of a package that moved others would load each module again
        sys.meta_path.insert(0, _ALIASES)


class _Aliases:  # finder and loader; importlib.abc would slow each start down
    def __init__(self):
        self.new_names = {}

    def _new_name(self, name):
        """Where the module of this old name is, or None; the nearest moved package decides."""
        package, rest = name, ""
        while package:
            if package in self.new_names:
                return self.new_names[package] + rest
            package, _, last = package.rpartition(".")
            rest = "." + last + rest
        return None

    def find_spec(self, name, path=None, target=None):
        new_name = self._new_name(name)
        return ModuleSpec(name, self, origin=new_name) if new_name else None

    def create_module(self, spec):
        return None  # an empty one, for a moment: the real one must keep its own __spec__

    def exec_module(self, module):
        name, new_name = module.__spec__.name, module.__spec__.origin
        try:
            # Python's import takes it from there
            sys.modules[name] = importlib.import_module(new_name)
        except ModuleNotFoundError as error:
            if not (new_name + ".").startswith(str(error.name) + "."):
                raise  # it is there, but something that it needs is not
            text = "no module %s, which is the name of %s now" % (new_name, name)
            raise ImportError(text, name=name) from error


_ALIASES = _Aliases()
