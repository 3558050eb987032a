#ifndef MESH_MAP_SRC_RADIUS_BLOCKS_H
#define MESH_MAP_SRC_RADIUS_BLOCKS_H

#include <mesh_map/radius_statistics.h>

namespace mesh_map {

/// The pass over cells of a grid: see RadiusSearch::GRID. `results` has room for what is wanted.
void radiusStatisticsByGrid(const RadiusQuery& query, double cell_size, RadiusStatistics& results);

}  // namespace mesh_map

#endif  // MESH_MAP_SRC_RADIUS_BLOCKS_H
