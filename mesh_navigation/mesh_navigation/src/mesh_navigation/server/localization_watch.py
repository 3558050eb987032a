"""Whether the robot is localized, by what localizers say of themselves."""

import threading
from typing import Dict, NamedTuple

from mesh_msgs.msg import LocalizationState
from mesh_msgs.text import one_line

STATES = (LocalizationState.LOST, LocalizationState.UNCERTAIN, LocalizationState.OK)
NEVER = "the robot is not localized: nothing has come on {} yet (localization_topic)"
SILENT = (
    "the robot is not localized: {} has been silent on {} for {:.2f} s, allowed are {:.2f} s "
    "(localization_timeout)"
)
AHEAD = (
    "the robot is not localized: what {} says is stamped {:.2f} s ahead of time, allowed are "
    "{:.2f} s (localization_timeout)"
)
UNKNOWN = "the robot is not localized: {} gives the state {}, which is none"
LOST = "the robot is not localized, says {}: {}"
UNCERTAIN = "the localization is uncertain, says {}: {}"
SEVERAL = "several nodes say on {} whether the robot is localized, the worst counts: {}"


class Localized(NamedTuple):
    """How well the robot is localized at one moment."""

    lost: str
    """Why it is not, as a sentence; empty: it is."""
    doubt: str
    """What is not as it should be, although it is localized; empty: nothing."""
    has_spoken: bool
    """Whether anybody has ever said anything."""
    times: int
    """How often it was localized again after it was not."""


class _Word(NamedTuple):
    """The last one of a localizer."""

    state: int
    reason: str
    stamp: float
    heard: float


class LocalizationWatch:
    """Hears those who say on one topic whether they know where the robot is. From any thread.

    Of several that speak, the worst counts; one that has fallen silent counts no more as long as
    another one speaks.
    """

    def __init__(self, topic: str, timeout: float) -> None:
        """
        Args:
            topic: for messages.
            timeout: who is silent for longer (s), or says something that is stamped so far ahead
                of time, does not know where the robot is.
        """
        self._topic, self._timeout = topic, timeout
        self._lock = threading.Lock()
        self._words: Dict[str, _Word] = {}
        self._now = 0.0
        self._was_lost, self._times = True, 0

    def hear(self, speaker: str, state: int, reason: str, stamp: float, now: float) -> None:
        """A message has come.

        Args:
            speaker: node that sent it.
            state: of LocalizationState; what is none of its constants counts as lost.
            reason: for people.
            stamp: of the scan that was judged (s).
            now: time (s), which may jump back; as for `look`.
        """
        with self._lock:
            self._take_time(now)
            spoke = self._speaking()
            self._words = {name: word for name, word in self._words.items() if name in spoke}
            reason = one_line(reason) or "no reason is given"
            self._words[speaker] = _Word(state, reason, stamp, now)
            self._judge()

    def look(self, now: float) -> Localized:
        """How well the robot is localized now (s)."""
        with self._lock:
            self._take_time(now)
            return self._judge()

    def _take_time(self, now: float) -> None:
        """Where time jumps back, all are as silent as they were before."""
        if now < self._now:
            self._words = {
                name: word._replace(heard=word.heard - (self._now - now))
                for name, word in self._words.items()
            }
        self._now = now

    def _speaking(self) -> Dict[str, _Word]:
        return {
            name: word
            for name, word in self._words.items()
            if self._now - word.heard <= self._timeout
        }

    def _judge(self) -> Localized:
        spoke = self._speaking()
        doubts = []
        lost = "" if spoke else self._silence_fault()
        for name, word in sorted(spoke.items(), key=lambda item: item[1].state):
            lost = lost or self._fault(name, word)
            if word.state == LocalizationState.UNCERTAIN:
                doubts.append(UNCERTAIN.format(name, word.reason))
        if len(spoke) > 1:
            doubts.append(SEVERAL.format(self._topic, ", ".join(sorted(spoke))))
        if self._was_lost and not lost:
            self._times += 1
        self._was_lost = bool(lost)
        return Localized(lost, "; ".join(doubts), bool(self._words), self._times)

    def _silence_fault(self) -> str:
        if not self._words:
            return NEVER.format(self._topic)
        name, word = max(self._words.items(), key=lambda item: item[1].heard)
        return SILENT.format(name, self._topic, self._now - word.heard, self._timeout)

    def _fault(self, name: str, word: _Word) -> str:
        """Why its word does not say where the robot is; empty if it does."""
        if word.state not in STATES:
            return UNKNOWN.format(name, word.state)
        if word.state == LocalizationState.LOST:
            return LOST.format(name, word.reason)
        ahead = word.stamp - self._now
        return AHEAD.format(name, ahead, self._timeout) if ahead > self._timeout else ""
