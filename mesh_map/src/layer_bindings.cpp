#include "layer_bindings.h"

namespace mesh_map {

void bindLayerKernels(pybind11::module&) {}

}  // namespace mesh_map
