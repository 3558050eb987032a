"""What the readers of all members of a part share."""
from mesh_msgs_hdf5.map_file.hdf5.guarded_group import GuardedGroup
from mesh_msgs_hdf5.map_file.reading.layouts import Layout


class PartReader:
    """A part of an open map file, without its members; nothing is read before it is asked for.

    Attributes: guarded (the group of the part), layout.
    """

    def __init__(self, guarded: GuardedGroup, layout: Layout) -> None:
        self.guarded = guarded
        self.layout = layout
