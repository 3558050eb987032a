#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>

#include "rviz_mesh_plugin/mesh_data.h"

namespace rviz_mesh_plugin {

/// Whether something is older than something else; what has no stamp (0) is neither older nor
/// newer.
constexpr bool isOlder(std::uint64_t stamp, std::uint64_t than)
{
  return stamp != 0 && than != 0 && stamp < than;
}

/// The costs of an update that count: itself if they all do, null if none does.
/// @param counts told the vertex and the stamp of a cost
CostUpdateConstPtr select(const CostUpdateConstPtr& update,
                          const std::function<bool(std::uint32_t, std::uint64_t)>& counts);

/// What is left of an update that came before an entire layer: costs that are newer than that.
CostUpdateConstPtr leftOver(const CostUpdateConstPtr& update, const CostLayer& layer);

/// The summary of a layer with more values than this is not made anew for an
/// update: its limits only widen until the whole layer comes again. Its counts
/// are exact.
constexpr std::size_t MAX_SUMMARIZED_AGAIN = 50000;

/// Changes the values that the update names, and the summary.
/// @return why nothing was changed: the update does not fit; else an empty
/// string
std::string applyUpdate(CostLayer& layer, const CostUpdate& update);

}  // namespace rviz_mesh_plugin
