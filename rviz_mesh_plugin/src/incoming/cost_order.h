#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <list>
#include <string>
#include <vector>

#include "base/mesh_data.h"

namespace rviz_mesh_plugin {

/// The summary of a layer with more values than this is not made anew for an
/// update: its limits only widen until the whole layer comes again. Its counts
/// are exact.
constexpr std::size_t MAX_SUMMARIZED_AGAIN = 50000;

/// Changes the values that the update names, and the summary.
/// @return why nothing was changed: the update does not fit; else an empty
/// string
std::string applyUpdate(CostLayer& layer, const CostUpdate& update);

/// Puts layers of costs and their updates in order, as they arrive: they may overtake each other on
/// their topics, so their stamps count as well. An update that is older than its layer is stale,
/// and so are its costs for vertices that have got newer ones; one that is newer than the layer
/// that comes after it counts still. Where stamps are equal, or there are none, the order of
/// arrival decides. (Updates of one layer have to have stamps all, or none.)
///
/// What it lets through only has to be applied in this order: there stamps do not count any more.
class CostOrder
{
 public:
  /// Updates wait for their layer up to this many values, and updates, however small.
  static constexpr std::size_t MAX_WAITING_VALUES = 1000000;
  static constexpr std::size_t MAX_WAITING_UPDATES = 10000;

  /// @param max_remembered of so many vertices of all layers the newest updates are known (12 bytes
  /// each), or of the layer that is updated if that is larger; of layers that have not been for the
  /// longest time, only their own stamp
  explicit CostOrder(std::size_t max_remembered = 32 * 1024 * 1024)
      : max_remembered_(max_remembered)
  {
  }

  /// An entire layer of vertices: it gets what newer updates have brought.
  /// @return why one that has waited for it does not fit; else empty
  std::string arrange(CostLayer& layer);

  /// What counts of an update; null where nothing does, or where it has to wait for its layer, and
  /// counts only if it is newer.
  /// @param problem why it does not fit its layer, or empty
  CostUpdateConstPtr arrange(const CostUpdateConstPtr& update, std::string& problem);

  /// How many updates were left out, because all they name was newer.
  std::size_t stale() const { return stale_; }
  /// How many values of updates wait for their layer.
  std::size_t waitingValues() const { return waiting_values_; }

  void forgetLayers() { layers_.clear(); }
  /// That wait for their layer.
  void forgetUpdates();

 private:
  /// A layer that has come, and what updates have changed in it.
  struct Layer
  {
    std::string uuid;
    std::string type;
    std::uint64_t stamp = 0;
    std::size_t size = 0;
    /// Of each vertex, those of its newest update; empty where none had a stamp.
    std::vector<std::uint64_t> stamps;
    std::vector<float> costs;
    std::uint64_t newest_stamp = 0;

    void remember(const CostUpdate& update);
  };

  template <class Costs>
  Layer* find(const Costs& costs);
  CostUpdateConstPtr counting(Layer& layer, const CostUpdateConstPtr& update, std::string& problem);
  void remember(Layer& layer, const CostUpdate& update);
  void keepWaiting(const CostUpdateConstPtr& update);

  const std::size_t max_remembered_;
  std::list<Layer> layers_;  ///< the last changed first
  std::deque<CostUpdateConstPtr> waiting_;
  std::size_t waiting_values_ = 0;
  std::size_t stale_ = 0;
};

}  // namespace rviz_mesh_plugin
