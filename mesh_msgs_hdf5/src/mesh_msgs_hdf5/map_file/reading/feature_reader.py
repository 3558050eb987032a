"""Reads texture features: a dataset for each, whose attribute is its place on the surface."""
from typing import Dict, Optional

import numpy as np

from mesh_msgs_hdf5.checks.check import MAX_FEATURES, checked_features
from mesh_msgs_hdf5.checks.exact import to_exact
from mesh_msgs_hdf5.map_file.hdf5.guarded_group import check_shape
from mesh_msgs_hdf5.map_file.hdf5.hdf5_attributes import row_attribute
from mesh_msgs_hdf5.map_file.hdf5.hdf5_guard import join
from mesh_msgs_hdf5.map_file.reading.part_reader import PartReader
from mesh_msgs_hdf5.model import schema
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.label_names import natural_order
from mesh_msgs_hdf5.model.mesh import Features


class FeatureReader(PartReader):
    """The texture features of a part, which are in a group of it, if the layout has one."""

    def feature_paths(self) -> Dict[str, str]:
        """Name -> absolute path in the file of each feature, in natural order of the names."""
        group = self.guarded.subgroup(self.layout.features) if self.layout.features else None
        if group is None:
            return {}
        names = self.guarded.dataset_names(self.layout.features, MAX_FEATURES)
        return {name: join(group, name) for name in sorted(names, key=natural_order)}

    @property
    def features(self) -> Optional[Features]:
        """The texture features; None if the file has none.

        Refuses descriptors of different lengths.
        """
        path = self.guarded.path
        descriptors, locations = [], []
        for name in self.feature_paths():
            found = self.guarded.dataset("%s/%s" % (self.layout.features, name))
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
            values = self.guarded.values(found).reshape(-1)
            descriptors.append(to_exact(values, "<f4", path, found.name))
            place = "%s of %s" % (schema.FEATURE_LOCATION, found.name)
            locations.append(to_exact(location, "<f4", path, place))
        if not descriptors:
            return None
        return checked_features(path, Features(np.stack(locations), np.stack(descriptors)))
