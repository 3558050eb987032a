#include "front_bindings.h"

namespace mesh_map {

void bindFrontKernels(pybind11::module&) {}

}  // namespace mesh_map
