#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "rviz_mesh_plugin/mesh_data.h"

namespace rviz_mesh_plugin {

class MeshPainters;
class MeshStore;

/// Updates of costs that have been stored, but are not seen yet: those that come in quick
/// succession become seen together. GUI thread only.
class PendingCosts
{
 public:
  using Clock = std::chrono::steady_clock;

  void take(const std::vector<CostUpdateConstPtr>& updates, MeshStore& store);

  /// @param rate in Hz: how often at most
  /// @return whether something has become seen
  bool show(Clock::time_point now, float rate, MeshPainters& painters);

  void clear() { changed_.clear(); }

 private:
  using Layer = std::pair<std::string, std::string>;  ///< uuid and type
  struct Changed
  {
    CostLayerConstPtr layer;
    std::vector<std::uint32_t> vertices;
  };

  std::map<Layer, Changed> changed_;
  Clock::time_point shown_;
};

}  // namespace rviz_mesh_plugin
