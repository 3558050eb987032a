#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "base/mesh_data.h"

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

/// Layers of costs and their updates on the way to the MeshStore. They may overtake each other on
/// their topics, so their stamps count as well: an update that is older than the layer that it
/// meets is stale, one that is newer than the layer that comes after it counts still. Where stamps
/// are equal, or there are none, the order of arrival decides.
///
/// Only what makes a difference is kept: in the store all is as if it had got each message when it
/// came. (Updates of one layer have to have stamps all, or none.)
struct CostNews
{
  /// To be applied before costs: newer than the layer that came after them, which does not tell
  /// whether they are newer than the one before it.
  std::vector<CostUpdateConstPtr> earlier_updates;
  std::vector<CostLayerConstPtr> costs;     ///< one per uuid, type and kind (vertices, faces)
  std::vector<CostUpdateConstPtr> updates;  ///< to be applied after costs, in this order
  std::size_t stale = 0;                    ///< updates left out, in all

  void add(const std::shared_ptr<CostLayer>& layer);
  void add(const CostUpdateConstPtr& update);
};

}  // namespace rviz_mesh_plugin
