#include "level_of_detail/overlay_levels.h"

#include <algorithm>
#include <map>
#include <mutex>
#include <utility>

#include "threads/cancellation.h"

namespace rviz_mesh_plugin {
namespace {

/// Those in use, by mesh.
struct Registry
{
  std::mutex making;  ///< one after the other: each takes all cores
  std::mutex mutex;
  std::map<std::weak_ptr<const MeshData>, std::weak_ptr<const OverlayLevels>, std::owner_less<>>
      levels;

  OverlayLevelsConstPtr find(const MeshDataConstPtr& mesh)
  {
    const std::lock_guard<std::mutex> lock(mutex);
    for (auto entry = levels.begin(); entry != levels.end();) {
      entry = entry->second.expired() ? levels.erase(entry) : std::next(entry);
    }
    const auto found = levels.find(mesh);
    return found == levels.end() ? nullptr : found->second.lock();
  }

  void keep(const MeshDataConstPtr& mesh, const OverlayLevelsConstPtr& made)
  {
    const std::lock_guard<std::mutex> lock(mutex);
    levels[mesh] = made;
  }
};

/// Never destroyed: threads may still use it while the process ends.
Registry& registry()
{
  static Registry& instance = *new Registry;
  return instance;
}

/// @param layout of the mesh, not split
OverlayLevelsConstPtr levelsOf(const MeshLayout& layout)
{
  auto levels = std::make_shared<OverlayLevels>();
  levels->faces = *layout.faces;
  levels->cell_sizes = layout.cell_sizes;
  levels->part_of.resize(layout.faces->size());
  levels->parts.resize(layout.parts.size());
  std::size_t count = 0;  // indices of simplified faces
  for (const MeshPart& part : layout.parts) {
    for (std::size_t level = 1; level < part.levels.size(); ++level) {
      count += part.levels[level].end() - part.levels[level].start;
    }
  }
  levels->indices.reserve(count);
  levels->owners.reserve(count / 3);
  std::vector<std::uint32_t> first_part(layout.vertices.size(), NONE);  // to use each vertex
  for (std::size_t i = 0; i < layout.parts.size(); ++i) {
    const IndexRange& full = layout.parts[i].levels.front();
    for (std::size_t k = full.start; k < full.end(); ++k) {
      std::uint32_t& part = first_part[layout.indices[k]];
      part = part == NONE ? static_cast<std::uint32_t>(i) : part;
    }
  }
  std::size_t place = 0;
  for (std::size_t i = 0; i < layout.parts.size(); ++i) {
    const MeshPart& from = layout.parts[i];
    OverlayLevels::Part& part = levels->parts[i];
    static_cast<Bounds&>(part) = from;
    part.drawn_beside = from.drawn_beside;
    part.begin = place;
    part.end = place += from.levels.front().count / 3;
    for (std::size_t face = part.begin; face < part.end; ++face) {
      levels->part_of[(*layout.faces)[face]] = static_cast<std::uint32_t>(i);
    }
    for (std::size_t level = 1; level < from.levels.size(); ++level) {
      const IndexRange& range = from.levels[level];
      part.levels.push_back(
          {static_cast<std::uint32_t>(levels->indices.size()), range.count, range.seam_count});
      for (std::size_t k = range.start; k < range.end(); ++k) {
        levels->indices.push_back(layout.sources[layout.indices[k]]);
      }
      for (std::size_t k = range.start; k < range.end(); k += 3) {
        levels->owners.push_back(first_part[layout.indices[k]]);
      }
    }
  }
  return levels;
}

/// 0 to 254, the same for each face at all times.
std::uint32_t thresholdOf(const std::uint32_t* corners)
{
  std::uint32_t mixed = corners[0] * 0x9E3779B1u ^ corners[1] * 0x85EBCA77u;
  mixed = (mixed ^ corners[2]) * 0xC2B2AE3Du;
  return (mixed ^ mixed >> 15) % 255;
}

}  // namespace

OverlayLevelsConstPtr OverlayLevels::of(const MeshDataConstPtr& mesh,
                                        const std::atomic<bool>& canceled)
{
  const std::lock_guard<std::mutex> making(registry().making);
  throwIfCanceled(&canceled);
  OverlayLevelsConstPtr levels = registry().find(mesh);
  if (!levels) {
    const MeshLayoutConstPtr layout = layOut(mesh, Split::NONE, nullptr, canceled);
    if (!layout) {
      throw Canceled();
    }
    levels = levelsOf(*layout);
    registry().keep(mesh, levels);
  }
  return levels;
}

OverlayFaces::OverlayFaces(MeshDataConstPtr mesh, OverlayLevelsConstPtr levels,
                           const std::vector<std::size_t>& drawn)
    : mesh_(std::move(mesh)),
      levels_(std::move(levels)),
      faces_(mesh_->faceCount()),
      counts_(levels_->parts.size(), 0),
      changed_(levels_->parts.size(), false)
{
  for (const std::size_t part : drawn) {
    change(part);
  }
}

void OverlayFaces::change(std::size_t part)
{
  left_ += changed_[part] ? 0 : 1;
  changed_[part] = true;
}

void OverlayFaces::setFaces(FaceBits faces)
{
  std::vector<std::size_t> turned;  // that were whole, or are: seams of others change
  for (std::size_t place = 0; place < faces_.wordCount(); ++place) {
    FaceBits::visitBits(faces_.word(place) ^ faces.word(place),
                        static_cast<std::uint32_t>(FaceBits::BITS * place),
                        [&](std::uint32_t face) {
                          const std::uint32_t part = levels_->part_of[face];
                          if (isWhole(part)) {
                            turned.push_back(part);
                          }
                          counts_[part] += faces.contains(face) ? 1 : std::size_t(-1);
                          change(part);
                        });
  }
  faces_ = std::move(faces);
  for (std::size_t part = 0; part < changed_.size(); ++part) {
    if (changed_[part] && isWhole(part)) {
      turned.push_back(part);
    }
  }
  for (const std::size_t part : turned) {
    for (const std::uint32_t beside : levels_->parts[part].drawn_beside) {
      change(beside);
    }
  }
}

std::vector<PartFaces> OverlayFaces::next(std::size_t bytes, const std::atomic<bool>& canceled)
{
  std::vector<PartFaces> made;
  // Of the thread, for all that it makes: four bytes a vertex of its largest mesh. All zero.
  static thread_local std::vector<Votes> votes;
  std::size_t size = 0;
  for (std::size_t part = 0; left_ > made.size() && (made.empty() || size < bytes); ++part) {
    if (changed_[part]) {
      throwIfCanceled(&canceled);
      try {
        made.push_back(make(part, votes));
      } catch (...) {
        votes = std::vector<Votes>();
        throw;
      }
      size += made.back().indices.size() * sizeof(std::uint32_t);
    }
  }
  for (const PartFaces& part : made) {
    changed_[part.part] = false;
  }
  left_ -= made.size();
  return made;
}

PartFaces OverlayFaces::make(std::size_t number, std::vector<Votes>& votes) const
{
  const OverlayLevels::Part& part = levels_->parts[number];
  const std::vector<std::uint32_t>& corners = mesh_->indices;
  PartFaces made;
  made.part = number;
  for (std::size_t place = part.begin; place < part.end; ++place) {
    const std::size_t face = levels_->faces[place];
    if (faces_.contains(static_cast<std::uint32_t>(face))) {
      made.indices.insert(made.indices.end(), &corners[3 * face], &corners[3 * face] + 3);
    }
  }
  if (made.indices.empty()) {
    return made;
  }
  const auto visitVotes = [&](const auto& visit) {
    for (std::size_t place = part.begin; place < part.end; ++place) {
      const std::uint32_t face = levels_->faces[place];
      for (std::size_t corner = 3 * std::size_t{face}; corner < 3 * std::size_t{face} + 3;
           ++corner) {
        visit(votes[corners[corner]], face);
      }
    }
  };
  const bool whole = made.indices.size() == 3 * (part.end - part.begin);
  made.whole = whole;
  if (!whole) {
    votes.resize(std::max(votes.size(), mesh_->vertexCount()));
    visitVotes([&](Votes& of_vertex, std::uint32_t face) {
      if (of_vertex.all < 0xFFFF) {
        ++of_vertex.all;
        of_vertex.in = static_cast<std::uint16_t>(of_vertex.in + (faces_.contains(face) ? 1 : 0));
      }
    });
  }
  made.levels.push_back({0, static_cast<std::uint32_t>(made.indices.size())});
  const auto isDrawn = [&](const std::uint32_t* face) {
    std::uint32_t all = 0, in = 0;
    for (std::size_t corner = 0; corner < 3 && !whole; ++corner) {
      all += votes[face[corner]].all;
      in += votes[face[corner]].in;
    }
    return whole || 255 * in > thresholdOf(face) * all;
  };
  for (const IndexRange& range : part.levels) {
    IndexRange drawn{static_cast<std::uint32_t>(made.indices.size())};
    for (std::size_t k = range.start; k < range.end(); k += 3) {
      const std::uint32_t* const face = &levels_->indices[k];
      const bool is_seam = k >= std::size_t{range.start} + range.count;
      if (is_seam ? isWhole(levels_->owners[k / 3]) : isDrawn(face)) {
        made.indices.insert(made.indices.end(), face, face + 3);
        (is_seam ? drawn.seam_count : drawn.count) += 3;
      }
    }
    made.levels.push_back(drawn);
  }
  if (!whole) {
    visitVotes([](Votes& of_vertex, std::uint32_t /*face*/) { of_vertex = Votes(); });
  }
  return made;
}

}  // namespace rviz_mesh_plugin
