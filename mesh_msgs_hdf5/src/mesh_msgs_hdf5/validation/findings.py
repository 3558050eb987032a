"""What is wrong or odd about a mesh: one finding for each rule and place."""
from typing import Dict, List, NamedTuple, Optional

ERROR, WARNING, NOTE = "error", "warning", "note"


class MapFinding(NamedTuple):
    """rule: one word for programs, a key of RULES or the code of a MapFileError; level: ERROR
    (it cannot be used), WARNING (it may surprise) or NOTE; where: the member, such as "faces" or
    "layer slope"; message: a sentence; first: the first index, count: of how many, or None.
    """

    rule: str
    level: str
    where: str
    message: str
    first: Optional[int] = None
    count: Optional[int] = None

    def line(self) -> str:
        """For a person."""
        place = "" if self.first is None else ", first: %d" % self.first
        number = "" if self.count is None else " (%d%s)" % (self.count, place)
        return "%s: %s [%s]: %s%s" % (self.level, self.where, self.rule, self.message, number)


# what each rule is about; errors have the codes of MapFileError instead
RULES: Dict[str, str] = {
    "repeated_vertex": "a face names a vertex twice",
    "zero_area": "a face has no area",
    "sliver": "a face is thinner than 1/1000 of its longest edge",
    "duplicate_faces": "two faces have the same three vertices",
    "duplicate_vertices": "two vertices have the same position",
    "isolated_vertices": "a vertex belongs to no face",
    "nonmanifold_edges": "more than two faces meet at an edge",
    "nonmanifold_vertices": "the faces at a vertex form more than one fan",
    "flipped_neighbors": "two neighbors are oriented against each other",
    "boundary": "an edge belongs to one face only",
    "components": "the surface has several parts that have no vertex in common",
    "faces_down": "more faces look down than up",
    "far_from_origin": "float32 is coarser than 1 mm at these coordinates",
    "normal_zero": "a normal has no direction",
    "normal_length": "a normal is not of length 1",
    "normal_flipped": "a normal points against the faces around its vertex",
    "layer_negative": "a cost is negative",
    "layer_unknown": "a cost is unknown (NaN)",
    "layer_all_unknown": "no value of a layer is known",
    "attribute_not_finite": "a value of an attribute is not finite",
    "label_empty": "a label has no faces",
    "labels_overlap": "a face has several labels",
    "texture_unused": "no material has this texture",
    "texture_coordinates_missing": "there are textures but no texture coordinates",
    "material_unused": "no face has this material",
    "lvr2_textures": "LVR2's MeshIO ends over textures as hdf5_map_io has them",
    "scan_name": "a group beside the scans is none by its name",
    "uuid_missing": "the file does not say the UUID of its geometry",
    "uuid_mismatch": "the UUID in the file is not that of its geometry",
    "journal": "labels in a journal beside the map are not in the map yet",
    "stale_temporary": "a program was killed while it saved this map",
}


def counts(findings: List[MapFinding]) -> Dict[str, int]:
    """How many findings there are of each level."""
    levels = [finding.level for finding in findings]
    return {level: levels.count(level) for level in (ERROR, WARNING, NOTE)}
