#include "level_of_detail/source_index.h"

#include <algorithm>
#include <numeric>

namespace rviz_mesh_plugin {
namespace {

constexpr std::size_t SLICE = 500000;

}  // namespace

// Counts are gathered two places after their source, and the runs filled by the places between:
// once all is done, each place holds where the run of its source starts.
SourceIndex::SourceIndex(const std::vector<std::uint32_t>& sources, std::size_t source_count)
    : sources_(sources), starts_(source_count + 2), vertices_(sources.size())
{
}

void SourceIndex::buildSlice()
{
  if (counted_ < sources_.size()) {
    const std::size_t end = std::min(counted_ + SLICE, sources_.size());
    for (; counted_ < end; ++counted_) {
      ++starts_[sources_[counted_] + 2];
    }
    if (counted_ == sources_.size()) {
      std::partial_sum(starts_.begin(), starts_.end(), starts_.begin());
    }
    return;
  }
  const std::size_t end = std::min(filled_ + SLICE, sources_.size());
  for (; filled_ < end; ++filled_) {
    vertices_[starts_[sources_[filled_] + 1]++] = static_cast<std::uint32_t>(filled_);
  }
}

void SourceIndex::find(std::uint32_t source, std::vector<std::uint32_t>* vertices) const
{
  if (std::size_t{source} + 2 < starts_.size()) {
    vertices->insert(vertices->end(), vertices_.begin() + starts_[source],
                     vertices_.begin() + starts_[source + 1]);
  }
}

}  // namespace rviz_mesh_plugin
