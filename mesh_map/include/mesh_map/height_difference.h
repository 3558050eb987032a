#ifndef MESH_MAP_HEIGHT_DIFFERENCE_H
#define MESH_MAP_HEIGHT_DIFFERENCE_H

#include <mesh_map/array_view.h>

#include <vector>

namespace mesh_map {

/// Height difference per vertex: max z - min z over the vertex itself and its neighborhood N_r (see
/// neighborhood.h). The vertex itself counts, so a vertex without neighbors has 0, not -inf as in
/// the released mesh_map.
std::vector<float> heightDifference(ArrayView<float> positions, const RowsView& neighbors,
                                    double radius, unsigned threads = 0);

}  // namespace mesh_map

#endif  // MESH_MAP_HEIGHT_DIFFERENCE_H
