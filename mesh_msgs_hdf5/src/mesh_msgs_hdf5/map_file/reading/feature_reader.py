"""Reads texture features: a dataset for each, whose attribute is its place on the surface."""
from collections import Counter
from typing import Dict, List, Optional, Tuple

import numpy as np

from mesh_msgs_hdf5.checks.check import MAX_FEATURES, check_finite, checked_features
from mesh_msgs_hdf5.checks.exact import to_exact
from mesh_msgs_hdf5.map_file.hdf5.guarded_group import check_shape
from mesh_msgs_hdf5.map_file.hdf5.hdf5_attributes import row_attribute
from mesh_msgs_hdf5.map_file.hdf5.hdf5_guard import join
from mesh_msgs_hdf5.map_file.reading.part_reader import PartReader
from mesh_msgs_hdf5.model import schema
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.label_names import natural_order
from mesh_msgs_hdf5.model.mesh import Features

_Feature = Tuple[str, np.ndarray, np.ndarray]  # name, location (3,), descriptor (D,)


class FeatureReader(PartReader):
    """The texture features of a part, which are in a group of it, if the layout has one."""

    def feature_paths(self) -> Dict[str, str]:
        """Name -> absolute path in the file of each feature, in natural order of the names."""
        return self.tolerated(self._feature_paths, {})

    def _feature_paths(self):
        group = self.guarded.subgroup(self.layout.features) if self.layout.features else None
        if group is None:
            return {}
        names = self.guarded.dataset_names(self.layout.features, MAX_FEATURES)
        return {name: join(group, name) for name in sorted(names, key=natural_order)}

    @property
    def features(self) -> Optional[Features]:
        """The texture features; None if the file has none that can be read.

        Where there are several kinds (SIFT beside SURF), those of the kind that there is most of:
        descriptors of one length.
        """
        read: List[_Feature] = []
        for name in self.feature_paths():
            self.tolerated(lambda name=name: read.append(self._feature(name, read)), None)
        read = self._of_one_kind(read)
        if not read:
            return None
        _, locations, descriptors = zip(*read)
        found = Features(np.stack(locations), np.stack(descriptors))
        return self.tolerated(lambda: checked_features(self.guarded.path, found), None)

    def _feature(self, name: str, before: List[_Feature]) -> _Feature:
        path = self.guarded.path
        found = self.guarded.dataset("%s/%s" % (self.layout.features, name))
        check_shape(path, found, 1)
        if self.strict and before and found.size != before[0][2].size:
            raise MapFileError(
                "shape",
                path,
                "%s has %d values, but the first feature has %d"
                % (found.name, found.size, before[0][2].size),
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
        location_name = "%s of %s" % (schema.FEATURE_LOCATION, found.name)
        descriptor = self._narrow(self.guarded.values(found).reshape(-1), found.name)
        location = self._narrow(location, location_name)
        if not self.strict:  # else one error says it of all
            check_finite(path, found.name, descriptor.reshape(1, -1))
            check_finite(path, location_name, location.reshape(1, -1))
        return found.name, location, descriptor

    def _narrow(self, values, name):
        """As float32(), with one note for all features."""
        if self.strict or values.dtype.kind != "f":
            return to_exact(values, "<f4", self.guarded.path, name)
        with np.errstate(all="ignore"):
            result = values.astype("<f4")
        if (result != values).any() and np.isfinite(result).all():
            self.note("rounded: the numbers of features are wider than float32")
        return result

    def _of_one_kind(self, read: List[_Feature]) -> List[_Feature]:
        sizes = [descriptor.size for _, _, descriptor in read]
        if len(set(sizes)) <= 1:
            return read
        counts = Counter(sizes)
        most = max(counts, key=counts.__getitem__)  # of as many, the first
        others = [feature for feature in read if feature[2].size != most]
        self.note(
            "left out: %d features that have not %d values as %d others do, first %s with %d"
            % (len(others), most, counts[most], others[0][0], others[0][2].size)
        )
        return [feature for feature in read if feature[2].size == most]
