#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "rviz_mesh_plugin/mesh_data.h"

namespace rviz_mesh_plugin {

/// A layer of costs with what updates have changed in it.
class StoredCosts
{
 public:
  explicit StoredCosts(CostLayerConstPtr layer);

  /// The same pointer from the first update on.
  const CostLayerConstPtr& layer() const { return layer_; }

  /// By an entire layer, but for values that newer updates have brought.
  void replace(const CostLayerConstPtr& layer);

  enum class Outcome
  {
    CHANGED,
    STALE,  ///< all that the update names is newer
    MISFIT  ///< nothing is changed
  };
  /// Changes the values that the update names and that are not newer.
  /// @param problem why it does not fit, or empty
  Outcome apply(const CostUpdateConstPtr& update, std::string& problem);

 private:
  std::uint64_t stampOf(std::uint32_t vertex) const;
  CostUpdateConstPtr newerThan(const CostLayer& layer) const;

  CostLayerConstPtr layer_;
  /// The same, once it has been updated: a copy that nobody else reads in another thread.
  std::shared_ptr<CostLayer> own_;
  /// Of each vertex, that of its newest update; empty where none had one.
  std::vector<std::uint64_t> stamps_;
  std::uint64_t newest_stamp_ = 0;
};

}  // namespace rviz_mesh_plugin
