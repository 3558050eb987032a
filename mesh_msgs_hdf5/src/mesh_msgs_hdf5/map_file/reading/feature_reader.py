"""Reads texture features: a dataset for each, whose attribute is its place on the surface."""
from typing import Dict, Optional

import numpy as np

from mesh_msgs_hdf5.checks.check import MAX_FEATURES, checked_features
from mesh_msgs_hdf5.checks.exact import to_exact
from mesh_msgs_hdf5.map_file.hdf5.guarded_group import GuardedGroup, check_shape
from mesh_msgs_hdf5.map_file.hdf5.hdf5_attributes import row_attribute
from mesh_msgs_hdf5.map_file.hdf5.hdf5_guard import join
from mesh_msgs_hdf5.model import schema
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.label_names import natural_order
from mesh_msgs_hdf5.model.mesh import Features


class FeatureReader:
    """The texture features of a part, which are in the group at a place ("": it has none)."""

    def __init__(self, part: GuardedGroup, place: str) -> None:
        self._part = part
        self._place = place

    def paths(self) -> Dict[str, str]:
        """Name -> absolute path in the file of each feature, in natural order of the names."""
        group = self._part.subgroup(self._place) if self._place else None
        if group is None:
            return {}
        names = self._part.dataset_names(self._place, MAX_FEATURES)
        return {name: join(group, name) for name in sorted(names, key=natural_order)}

    def features(self) -> Optional[Features]:
        """All features; None if there are none. Refuses descriptors of different lengths."""
        path = self._part.path
        descriptors, locations = [], []
        for name in self.paths():
            found = self._part.dataset("%s/%s" % (self._place, name))
            check_shape(path, found, 1)
            if descriptors and found.size != descriptors[0].size:
                raise MapFileError(
                    "shape",
                    path,
                    "%s has %d values, but the first feature has %d"
                    % (found.name, found.size, descriptors[0].size),
                    "all features of a map are of one kind",
                )
            location = row_attribute(path, found, schema.FEATURE_LOCATION, 3)
            if location is None:
                raise MapFileError(
                    "value",
                    path,
                    "%s has no attribute %s" % (found.name, schema.FEATURE_LOCATION),
                    "the place of a feature: x, y, z in meters",
                )
            values = self._part.values(found).reshape(-1)
            descriptors.append(to_exact(values, "<f4", path, found.name))
            place = "%s of %s" % (schema.FEATURE_LOCATION, found.name)
            locations.append(to_exact(location, "<f4", path, place))
        if not descriptors:
            return None
        return checked_features(path, Features(np.stack(locations), np.stack(descriptors)))
