#include "level_of_detail/part_masks.h"

#include <algorithm>

#include "threads/cancellation.h"

namespace rviz_mesh_plugin {
namespace {

/// Of each vertex of the mesh, which one of the layout it is.
std::vector<std::uint32_t> placesOf(const LayoutOutline& layout)
{
  std::vector<std::uint32_t> places(layout.mesh->vertexCount(), NONE);
  for (std::size_t i = layout.sources.size(); i-- > 0;) {  // copies stand behind all others
    places[layout.sources[i]] = static_cast<std::uint32_t>(i);
  }
  return places;
}

}  // namespace

PartMasks maskParts(const LayoutOutline& layout, const HiddenFacesConstPtr& hidden,
                    const std::atomic<bool>& canceled)
{
  PartMasks found;
  if (!layout.faces || !hidden || hidden->bits().size() != layout.mesh->faceCount()) {
    return found;
  }
  const std::vector<std::uint32_t>& faces = *layout.faces;
  const auto isHidden = [&](std::uint32_t face) { return hidden->contains(face); };
  std::vector<std::uint32_t> places;
  std::vector<bool> masked(layout.parts.size());
  for (std::size_t i = 0, begin = 0; i < layout.parts.size(); ++i) {
    throwIfCanceled(&canceled);
    const std::size_t end = begin + layout.parts[i].levels.front().count / 3;
    if (std::any_of(faces.begin() + begin, faces.begin() + end, isHidden)) {
      if (places.empty()) {
        places = placesOf(layout);
      }
      masked[i] = true;
      found.masks.push_back({i, {}});
      for (std::size_t place = begin; place < end; ++place) {
        for (std::size_t k = 0; k < 3 && !isHidden(faces[place]); ++k) {
          const std::size_t corner = 3 * std::size_t{faces[place]} + k;
          found.masks.back().indices.push_back(places[layout.mesh->indices[corner]]);
        }
      }
    }
    begin = end;
  }
  for (std::size_t i = 0; i < layout.parts.size(); ++i) {
    const auto& beside = layout.parts[i].drawn_beside;
    if (masked[i]) {
      found.in_full.insert(found.in_full.end(), beside.begin(), beside.end());
    } else if (std::any_of(beside.begin(), beside.end(),
                           [&](std::uint32_t other) { return masked[other]; })) {
      found.in_full.push_back(i);
    }
  }
  const auto isMasked = [&](std::size_t part) { return masked[part]; };
  found.in_full.erase(std::remove_if(found.in_full.begin(), found.in_full.end(), isMasked),
                      found.in_full.end());
  std::sort(found.in_full.begin(), found.in_full.end());
  found.in_full.erase(std::unique(found.in_full.begin(), found.in_full.end()), found.in_full.end());
  return found;
}

}  // namespace rviz_mesh_plugin
