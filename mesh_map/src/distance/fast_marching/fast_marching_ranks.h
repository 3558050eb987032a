#pragma once

#include <algorithm>
#include <cstdint>
#include <unordered_map>

namespace mesh_map {

/// In which order labels follow from each other, while they are repaired: each from lower ranks
/// alone, so that none follows from itself. The rank of a vertex is its label; where that follows
/// from others that are not below it (across obtuse corners), what is kept here: above theirs.
class FastMarchingRanks
{
 public:
  void clear()
  {
    ranks_.clear();
    highest_ = -1.0;
  }

  /// Has no vertex with this label or a higher one another rank?
  bool areLabelsFrom(double label) const { return highest_ <= label; }

  double of(std::uint32_t v, double label) const
  {
    if (areLabelsFrom(label)) {
      return label;
    }
    const auto found = ranks_.find(v);
    return found != ranks_.end() ? found->second : label;
  }

  void set(std::uint32_t v, double rank)
  {
    ranks_[v] = rank;
    highest_ = std::max(highest_, rank);
  }

  /// Its rank is its label again.
  void forget(std::uint32_t v) { ranks_.erase(v); }

 private:
  std::unordered_map<std::uint32_t, double> ranks_;
  double highest_ = -1.0;  // of all that there were
};

}  // namespace mesh_map
