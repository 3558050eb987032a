"""The log of the library on rosout."""

import logging

import rospy
from mesh_msgs.text import one_line


_LOG = logging.getLogger("mesh_map")


class _ToRosLog(logging.Handler):
    """Passes what the library logs on to rosout."""

    def emit(self, record: logging.LogRecord) -> None:
        text = one_line(record.getMessage())
        if record.levelno >= logging.ERROR:
            rospy.logerr("%s", text)
        elif record.levelno >= logging.WARNING:
            rospy.logwarn("%s", text)
        elif record.levelno >= logging.INFO:
            rospy.loginfo("%s", text)


def forward_log() -> None:
    """Sends the log of the library to rosout, once per process."""
    if not any(isinstance(handler, _ToRosLog) for handler in _LOG.handlers):
        _LOG.addHandler(_ToRosLog())
        _LOG.setLevel(logging.INFO)
        _LOG.propagate = False
