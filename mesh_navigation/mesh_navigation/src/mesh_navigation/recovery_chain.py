"""Which recovery behavior is next."""

import enum
from typing import List, Optional, Sequence, Set


class Trouble(enum.Enum):
    """What recovery behaviors are tried for."""

    PLANNING = "planning"
    DRIVING = "driving"


class RecoveryChain:
    """Behaviors in their order, each once; from the first again when the troubles are overcome.

    Troubles are kept apart: a plan that is found again does not help a robot that still gets
    nowhere, so that the two taking turns come to an end too.
    """

    def __init__(self, behaviors: Sequence[str]) -> None:
        self._behaviors = list(behaviors)
        self._tried = 0
        self._troubles: Set[Trouble] = set()

    @property
    def tried(self) -> List[str]:
        """Those that were tried since the last start."""
        return self._behaviors[: self._tried]

    @property
    def exhausted(self) -> bool:
        """Whether there is none left."""
        return self._tried >= len(self._behaviors)

    def next(self, trouble: Trouble) -> Optional[str]:
        """The behavior to try for a trouble; None if there is none left."""
        self._troubles.add(trouble)
        if self.exhausted:
            return None
        self._tried += 1
        return self._behaviors[self._tried - 1]

    def overcome(self, trouble: Trouble) -> bool:
        """A trouble is over. Returns whether the chain starts anew, now that the last one is."""
        if trouble not in self._troubles:
            return False
        self._troubles.discard(trouble)
        if self._troubles:
            return False
        self._tried = 0
        return True
