#pragma once

#include <cstddef>
#include <string>

#include "rviz_mesh_plugin/mesh_data.h"

namespace rviz_mesh_plugin {

/// The summary of a layer with more values than this is not made anew for an
/// update: its limits only widen until the whole layer comes again. Its counts
/// are exact.
constexpr std::size_t MAX_SUMMARIZED_AGAIN = 50000;

/// Changes the values that the update names, and the summary.
/// @return why nothing was changed: the update does not fit; else an empty
/// string
std::string applyUpdate(CostLayer& layer, const CostUpdate& update);

}  // namespace rviz_mesh_plugin
