"""The errors of this package."""

from mesh_msgs.text import one_line


class MeshMapError(Exception):
    """A map, layer or parameter that cannot be used.

    str() is one line: what is wrong, and the way out if there is one.

    Attributes: message, hint (may be empty).
    """

    def __init__(self, message: str, hint: str = "") -> None:
        super().__init__(message, hint)
        self.message = message
        self.hint = hint

    def __str__(self) -> str:
        return one_line(self.message + (" (%s)" % self.hint if self.hint else ""))


class PluginError(MeshMapError):
    """A plugin that is not known, or cannot be loaded."""


class UnknownPluginError(PluginError):
    """A plugin that is not known; the hint names those that are."""


class Canceled(Exception):
    """Something long was ended by its CancelFlag; nothing has changed."""


Cancelled = Canceled  # documented before; for one release


# What a stranger's plugin may raise; SystemExit, too, which would end a thread without a word.
PLUGIN_FAILURES = (Exception, SystemExit)


def error_line(error: BaseException) -> str:
    """One line for users; errors that are not for users are named with their type."""
    if isinstance(error, MeshMapError):
        return str(error)
    return "%s: %s" % (type(error).__name__, one_line(error))
