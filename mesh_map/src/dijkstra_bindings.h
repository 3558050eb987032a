#ifndef MESH_MAP_DIJKSTRA_BINDINGS_H
#define MESH_MAP_DIJKSTRA_BINDINGS_H

#include <pybind11/pybind11.h>

namespace mesh_map {

void bindDijkstra(pybind11::module& module);

}  // namespace mesh_map

#endif  // MESH_MAP_DIJKSTRA_BINDINGS_H
