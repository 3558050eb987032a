#ifndef MESH_MAP_GEODESIC_BINDINGS_H
#define MESH_MAP_GEODESIC_BINDINGS_H

#include <pybind11/pybind11.h>

namespace mesh_map {

void bindGeodesicKernels(pybind11::module& module);

}  // namespace mesh_map

#endif  // MESH_MAP_GEODESIC_BINDINGS_H
