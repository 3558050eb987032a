#include "measurement/section_copies.h"

#include <algorithm>
#include <cstdint>
#include <unordered_set>

#include "measurement/union_find.h"

namespace rviz_mesh_plugin {

void removeCopies(const std::vector<SectionNode>& nodes, std::vector<SectionSegment>& segments)
{
  const auto remove = [&](const auto& is_copy) {
    segments.erase(std::remove_if(segments.begin(), segments.end(), is_copy), segments.end());
  };
  std::unordered_set<std::uint64_t> known;
  const auto key = [](std::uint32_t a, std::uint32_t b) { return std::uint64_t{a} << 32 | b; };
  remove([&](const SectionSegment& one) { return !known.insert(key(one.a, one.b)).second; });

  UnionFind parts(nodes.size());
  for (const SectionSegment& segment : segments) {
    parts.unite(segment.a, segment.b);
  }
  std::vector<bool> one_sided(nodes.size(), false);
  for (const SectionSegment& segment : segments) {
    if (known.count(key(segment.b, segment.a)) == 0) {
      one_sided[parts.find(segment.a)] = true;
    }
  }
  for (SectionSegment& segment : segments) {
    segment.two_sided = !one_sided[parts.find(segment.a)];
  }
  remove([&](const SectionSegment& one) { return one.two_sided && one.a > one.b; });
}

}  // namespace rviz_mesh_plugin
