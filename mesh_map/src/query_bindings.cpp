#include "query_bindings.h"

namespace mesh_map {

void bindQueryKernels(pybind11::module&) {}

}  // namespace mesh_map
