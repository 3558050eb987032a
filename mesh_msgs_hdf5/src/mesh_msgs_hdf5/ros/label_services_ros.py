"""The services for labels that both nodes have."""
from typing import Any, Callable, List

import rospy
from mesh_msgs import array_services, arrays
from mesh_msgs.srv import GetLabelGroups, GetLabelGroupsResponse

from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.ros.label_colors_ros import Found
from mesh_msgs_hdf5.ros.label_forwarding_ros import LabelForwarder
from mesh_msgs_hdf5.ros.map_messages import cluster, clusters


class LabelServices:
    """get_labeled_clusters, get_label_groups, get_labeled_cluster_group and delete_label."""

    def __init__(
        self,
        prefix: str,
        find: Callable[[str], Found],
        answering: Callable[[Callable[[Any], Any]], Callable[[Any], Any]],
        forwarder: LabelForwarder,
        deleted: Callable[[str, Any, arrays.MeshFaceCluster], None],
    ) -> None:
        """prefix, find, answering: as in LabelColorServices.

        deleted: called with the UUID, its labels and a cluster that has the text and no faces.
        """
        self._find = find
        self._forwarder = forwarder
        self._deleted = deleted
        self._services: List[rospy.Service] = [
            rospy.Service(prefix + name, kind, answering(handler))
            for name, kind, handler in (
                ("get_labeled_clusters", array_services.GetLabeledClusters, self._get_all),
                ("get_label_groups", GetLabelGroups, self._get_groups),
                ("get_labeled_cluster_group", array_services.GetLabeledClusterGroup, self._get),
                ("delete_label", array_services.DeleteLabel, self._delete),
            )
        ]

    def _get_all(self, request):
        found = clusters(self._find(request.uuid)[1].all())
        return array_services.GetLabeledClustersResponse(clusters=found)

    def _get_groups(self, request):
        return GetLabelGroupsResponse(labels=self._find(request.uuid)[1].groups())

    def _get(self, request):
        found = clusters(self._find(request.uuid)[1].group(request.labelGroup))
        return array_services.GetLabeledClusterGroupResponse(clusters=found)

    def _delete(self, request):
        uuid, labels = self._find(request.uuid)
        try:
            deleted = cluster(request.label, labels.delete(request.label))
        except MapFileError as error:
            if error.code != "owned":
                raise
            deleted = self._forwarder.delete(labels, request.label)
        self._deleted(uuid, labels, arrays.MeshFaceCluster(label=request.label))
        return array_services.DeleteLabelResponse(cluster=deleted)
