"""Which of some files were saved since a moment, whoever did it: also a process that was ended."""
import os
from typing import Dict, Iterable, List

from mesh_msgs_hdf5.files.save import Stamp, is_temporary, stamp


class SavedFiles:
    """The files at some paths as they are now, with their label journals; of folders what is in
    them. Words that are no paths do no harm."""

    def __init__(self, words: Iterable[str]) -> None:
        self._words = [word for word in dict.fromkeys(words) if word and "\0" not in word]
        self._before = self._found()

    def since(self) -> List[str]:
        """The paths, as they were given, of those that are there and are others than then."""
        before = self._before
        return [path for path, now in self._found().items() if before.get(path) != now]

    def _found(self) -> Dict[str, Stamp]:
        found = {}
        for word in self._words:
            paths = [word, word + ".journal"]
            if os.path.isdir(word):
                paths = [os.path.join(word, name) for name in _names(word)]
            for path in paths:
                now = stamp(path) if os.path.isfile(path) else None
                if now is not None:
                    found[path] = now
        return found


def _names(folder):
    try:
        return [name for name in sorted(os.listdir(folder)) if not is_temporary(name)]
    except OSError:
        return []
