"""Everything in an HDF5 file as it is stored, for comparing files; and strange things to keep."""
import h5py
import numpy as np


def raw_contents(path, skip=()):
    """Path -> what is there: kinds, types, attributes, links and stored bytes, as plain values.

    skip: paths that are left out with all below them. Written with plain h5py, and not from what
    the package compares.
    """
    with h5py.File(path, "r") as file:
        return _Walk(file, set(skip)).found


def without(contents, skip):
    """What raw_contents() gives with that skip, from what it gives without."""
    below = tuple(place + "/" for place in skip)
    return {
        place: kind
        for place, kind in contents.items()
        if place not in skip and not place.startswith(below)
    }


class _Walk:
    def __init__(self, file, skip):
        self._file = file
        self._skip = skip
        self._names = {}  # of each object: the first that is met
        self._name_all("", file["/"])
        self.found = {"/": ("root", self._attributes(file), file.userblock_size)}
        self._visit("", file)

    def _name_all(self, prefix, group):
        for name in sorted(group):
            if isinstance(group.get(name, getlink=True), h5py.HardLink):
                place = prefix + "/" + name
                address = h5py.h5o.get_info(group[name].id).addr
                if address not in self._names:
                    self._names[address] = place
                    if isinstance(group[name], h5py.Group):
                        self._name_all(place, group[name])

    def _visit(self, prefix, group):
        for name in group:
            place = prefix + "/" + name
            if place not in self._skip:
                self.found[place] = self._object(place, group, name)

    def _object(self, place, group, name):
        link = group.get(name, getlink=True)
        if isinstance(link, h5py.ExternalLink):
            return ("external", link.filename, link.path)
        if isinstance(link, h5py.SoftLink):
            return ("soft", link.path)
        item = group[name]
        if isinstance(item, h5py.Group):
            self._visit(place, item)
            return ("group", self._attributes(item))
        if isinstance(item, h5py.Datatype):
            return ("type", str(item.dtype), self._attributes(item))
        return ("dataset",) + self._dataset(item)

    def _attributes(self, item):
        found = {}
        for name in item.attrs:
            attribute = h5py.h5a.open(item.id, name.encode("utf-8", "surrogateescape"))
            value = self._plain(item.attrs[name])
            found[name] = (attribute.get_type().encode(), attribute.shape, value)
        return found

    def _dataset(self, item):
        properties = item.id.get_create_plist()
        filters = tuple(properties.get_filter(i) for i in range(properties.get_nfilters()))
        header = (item.id.get_type().encode(), item.shape, item.maxshape, item.chunks, filters)
        header += (self._attributes(item), properties.get_layout())
        if item.chunks and not item.dtype.hasobject:
            infos = [item.id.get_chunk_info(i) for i in range(item.id.get_num_chunks())]
            offsets = sorted(info.chunk_offset for info in infos)
            return header + (
                tuple((offset, item.id.read_direct_chunk(offset)) for offset in offsets),
            )
        return header + (self._plain(item[()]),)

    def _plain(self, value):
        """Values without addresses: a reference is the name that it leads to."""
        if isinstance(value, h5py.Reference):
            if not value:
                return ("to nothing",)
            target = self._file[value]
            if isinstance(value, h5py.RegionReference):
                return ("to", target[value].tobytes())
            return ("to", self._names[h5py.h5o.get_info(target.id).addr])
        if isinstance(value, (np.ndarray, np.void)) and value.dtype.names:
            return [self._plain(value[name]) for name in value.dtype.names]
        if isinstance(value, np.ndarray) and value.dtype.hasobject:
            return [self._plain(inner) for inner in value.reshape(-1).tolist()]
        if isinstance(value, (np.ndarray, np.generic)):
            return (str(value.dtype), value.tobytes())
        if isinstance(value, h5py.Empty):
            return ("empty", str(value.dtype))
        return repr(value)


def add_strange_things(path, part="mesh"):
    """What other programs may keep in a map file, in all places where something of ours is too."""
    with h5py.File(path, "r+") as file:
        file.attrs["made by"] = ["another", "program"]
        scans = file.create_group("raw/scans", track_order=True)
        scans.attrs["pose"] = np.arange(16.0).astype(">f8").reshape(4, 4)
        scans.attrs["nothing"] = h5py.Empty("f4")
        scans.attrs["fixed"] = np.bytes_(b"abc")
        scans.attrs["record"] = np.array((1, 2.5), [("a", "<i2"), ("b", ">f8")])
        scans.create_dataset("z", data=np.arange(5000), chunks=(100,), compression="lzf")
        scans.create_dataset("checked", data=np.arange(999.0), fletcher32=True)
        scans.create_dataset("scaled", data=np.arange(999), scaleoffset=True)
        holes = scans.create_dataset("holes", (1000, 10), "i2", chunks=(10, 10), fillvalue=7)
        holes[500:510] = 3
        scans.create_dataset("grows", data=np.ones((3, 4)), maxshape=(None, 4))
        scans["never written"] = h5py.Empty("f4")
        scans.create_dataset("late", (1000,), "f4")
        scans["compound"] = np.zeros(3, [("index", "<i4"), ("r", "u1"), ("name", "S4")])
        scans["text"] = np.array(["ä", "b", ""], dtype=h5py.string_dtype())
        ragged = scans.create_dataset("ragged", (2,), dtype=h5py.vlen_dtype(np.int16))
        ragged[0], ragged[1] = [1, 2, 3], []
        scans["enum"] = np.array([0, 1], dtype=h5py.enum_dtype({"NO": 0, "YES": 1}, basetype="i1"))
        scans["opaque"] = np.zeros(3, "V5")
        scans["scalar"] = 5
        scans["again"] = file["raw/scans/z"]
        link = scans.create_dataset("link", (3,), dtype=h5py.ref_dtype)
        link[0], link[1] = file["raw/scans"].ref, scans["z"].ref
        region = scans.create_dataset("region", (1,), dtype=h5py.regionref_dtype)
        region[0] = scans["z"].regionref[3:9]
        scans["z"].attrs["of"] = scans["holes"].ref
        scans["z"].make_scale("time")
        scans["steps"] = np.arange(5000)
        scans["steps"].dims[0].attach_scale(scans["z"])
        file["type"] = np.dtype("<i4")
        file["raw/typed"] = np.arange(3, dtype="<i4")
        group = file[part] if part else file
        group.require_group("labels").require_group("tree")["notes"] = h5py.SoftLink("/nowhere")
        group["channels/face_normals"] = np.zeros((60, 3), "f4")
        group["channels/edge_distances"] = np.zeros((70, 1), "f4")
        group["channels/edge_distances_idx"] = np.zeros((70, 1), "u4")
        group["channels"].attrs["kept"] = "yes"
        group.require_group("clustersets")["mine"] = np.zeros(3)
        group.attrs["operator"] = "no one"
        group["soft"] = h5py.SoftLink("/nowhere")
        group["also raw"] = file["raw"]
        file["outside"] = h5py.ExternalLink("/etc/passwd", "/x")
        file["mesh 2/channels/vertices"] = np.zeros((3, 3), "f4")
