"""The robot looked for on the map, when somebody asks."""

import threading
from typing import Callable, NamedTuple, Optional

import rospy
from mesh_map.base.cancel import CancelFlag
from mesh_map.base.errors import Canceled, MeshMapError
from mesh_map.geometry.mesh_geometry import MeshGeometry
from std_srvs.srv import Trigger, TriggerRequest, TriggerResponse

from mesh_localization.relocalization.global_search import (
    GlobalSearch,
    PoseFit,
    SearchOptions,
    SearchState,
)
from mesh_localization.relocalization.pose_sampling import SearchRegion
from mesh_localization.sensing.placed_scan import PlacedScan
from mesh_localization.tracking.localizer import TrackingOptions


class Question(NamedTuple):
    """What is looked for.

    Attributes:
        geometry: of the map.
        scan: where it was made.
        tracking: when a place is believed.
        base_height: m of the base above the ground.
        region: where; None: everywhere.
    """

    geometry: MeshGeometry
    scan: PlacedScan
    tracking: TrackingOptions
    base_height: float
    region: Optional[SearchRegion] = None


class Relocalization:
    """Services `~relocalize` and `~relocalize_nearby` (std_srvs/Trigger). A search works in the
    thread of the service that asks, one at a time; the robot is followed meanwhile.

    Attributes:
        progress: what is being done, for people; empty where there is no search.
    """

    def __init__(
        self,
        question: Callable[[bool], Question],
        found: Callable[[PoseFit, PlacedScan], None],
    ) -> None:
        """
        Args:
            question: whether nearby -> what is looked for; MeshMapError: nothing can be, and why.
            found: gets where the robot is, in the thread of the service.
        """
        self.progress = ""
        self._question, self._found = question, found
        self._lock = threading.Lock()  # held while a search works
        self._cancel = CancelFlag()
        rospy.on_shutdown(self.give_up)
        rospy.Service("~relocalize", Trigger, self._everywhere)
        rospy.Service("~relocalize_nearby", Trigger, self._nearby)

    def give_up(self) -> None:
        """End the search that works; from any thread."""
        self._cancel.set()

    def _everywhere(self, _request: TriggerRequest) -> TriggerResponse:
        return self._answer(False)

    def _nearby(self, _request: TriggerRequest) -> TriggerResponse:
        return self._answer(True)

    def _answer(self, nearby: bool) -> TriggerResponse:
        answer = self._searched(nearby)
        text = "%s: %s" % (rospy.get_name(), answer.message)
        (rospy.loginfo if answer.success else rospy.logwarn)("%s", text)
        return answer

    def _searched(self, nearby: bool) -> TriggerResponse:
        if not self._lock.acquire(blocking=False):
            return TriggerResponse(success=False, message="the robot is being looked for already")
        try:
            self._cancel = CancelFlag()
            self._tell(0.0)
            question = self._question(nearby)
            search = GlobalSearch(
                question.geometry,
                SearchOptions(base_height=question.base_height),
                question.tracking,
            )
            result = search.search(
                question.scan.scan,
                region=question.region,
                progress=self._tell,
                cancel=self._cancel,
            )
            if result.state == SearchState.FOUND and result.best is not None:
                self._found(result.best, question.scan)
                return TriggerResponse(success=True, message=result.reason)
            return TriggerResponse(success=False, message=result.reason)
        except Canceled:
            return TriggerResponse(
                success=False, message="the search was given up: a pose was told meanwhile"
            )
        except MeshMapError as error:
            return TriggerResponse(
                success=False, message="the robot cannot be looked for: %s" % error
            )
        finally:
            self.progress = ""
            self._lock.release()

    def _tell(self, share: float) -> None:
        self.progress = "the robot is being looked for: %.0f %%" % (100 * share)
