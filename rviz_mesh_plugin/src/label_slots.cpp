#include "rviz_mesh_plugin/label_slots.h"

#include <algorithm>

namespace rviz_mesh_plugin {
namespace {

/// An upload of its own costs about as much as this many unchanged faces.
constexpr std::size_t GAP = 64;

}  // namespace

std::vector<LabelSlots::Range> LabelSlots::assign(const std::vector<std::uint32_t>& faces)
{
  if (faces_.empty()) {
    faces_ = faces;
    return joined({{0, faces_.size()}}, faces_.size());
  }
  std::uint32_t greatest = 0;
  for (const std::uint32_t face : faces) {
    greatest = std::max(greatest, face);
  }
  std::vector<bool> wanted(static_cast<std::size_t>(greatest) + 1, false);
  for (const std::uint32_t face : faces) {
    wanted[face] = true;
  }
  std::vector<std::size_t> holes;
  for (std::size_t place = 0; place < faces_.size(); ++place) {
    const std::uint32_t face = faces_[place];
    if (face < wanted.size() && wanted[face]) {
      wanted[face] = false;
    } else {
      holes.push_back(place);
    }
  }
  std::vector<Range> changed;
  const auto put = [&](std::size_t place, std::uint32_t face) {
    faces_[place] = face;
    if (!changed.empty() && changed.back().end == place) {
      ++changed.back().end;
    } else {
      changed.push_back({place, place + 1});
    }
  };
  std::size_t filled = 0;
  for (const std::uint32_t face : faces) {
    if (!wanted[face]) {
      continue;
    }
    wanted[face] = false;
    if (filled == holes.size()) {
      faces_.push_back(face);
      put(faces_.size() - 1, face);
    } else {
      put(holes[filled++], face);
    }
  }
  // What is left of the holes is closed from the end.
  while (holes.size() > filled) {
    if (holes.back() != faces_.size() - 1) {
      put(holes[filled++], faces_.back());
    } else {
      holes.pop_back();
    }
    faces_.pop_back();
  }
  return joined(std::move(changed), faces_.size());
}

std::vector<LabelSlots::Range> joined(std::vector<LabelSlots::Range> ranges, std::size_t end)
{
  std::sort(ranges.begin(), ranges.end(),
            [](const auto& a, const auto& b) { return a.begin < b.begin; });
  std::vector<LabelSlots::Range> result;
  for (const LabelSlots::Range& range : ranges) {
    const std::size_t stop = std::min(range.end, end);
    if (range.begin >= stop) {
      continue;
    }
    if (!result.empty() && range.begin <= result.back().end + GAP) {
      result.back().end = std::max(result.back().end, stop);
    } else {
      result.push_back({range.begin, stop});
    }
  }
  return result;
}

}  // namespace rviz_mesh_plugin
