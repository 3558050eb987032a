#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "rviz_mesh_plugin/mesh_data.h"

namespace rviz_mesh_plugin {

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
