#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "reconstruction/measured_rays.h"
#include "reconstruction/voxel_blocks.h"

namespace mesh_map {

/// A ray in a block of voxels.
struct BlockPassage
{
  const BlockPassage* next = nullptr;  ///< the next one in the block
  std::uint32_t block = 0, ray = 0;
  std::uint32_t first = 0, count = 0;  ///< its voxels: places in the block; none of what is carved
};

/// All rays in a block, in the order of their points.
struct BlockPassages
{
  std::uint32_t block, count = 0;
  const BlockPassage* first = nullptr;
  BlockPassage* last = nullptr;
};

/// Where the rays of a batch pass which blocks.
class PassageLists
{
 public:
  static constexpr std::size_t RAYS = 1024;  ///< of a list, which one thread makes at a time
  static constexpr std::size_t PADDING = 3;  ///< voxels behind those of a passage that can be read

  explicit PassageLists(std::size_t rays) : lists_((rays + RAYS - 1) / RAYS) {}
  std::size_t size() const { return lists_.size(); }

  /// Makes a list: aims its rays by the normals at their points. To be called once for each.
  void list(std::size_t number, MeasuredRays& rays, const SurfaceNormals& normals,
            const std::vector<std::uint32_t>& cells, const KeyIndex& blocks, bool carve);

  /// Numbers blocks that are new, as they come along the rays, and calls added() after each. Then
  /// gives the passages by block, with those first that have many.
  std::vector<BlockPassages> byBlock(KeyIndex& blocks, const std::function<void()>& added);

  const std::uint16_t* voxels(const BlockPassage& passage) const
  {
    return lists_[passage.ray / RAYS].voxels.data() + passage.first;
  }

 private:
  static constexpr std::uint64_t NOWHERE = ~std::uint64_t{0};

  struct List
  {
    List() = default;
    explicit List(const KeyIndex& blocks);

    void add(const CellWalk& walk, std::uint32_t ray);        // through voxels
    void addCarved(const CellWalk& walk, std::uint32_t ray);  // through blocks; old ones count
    std::uint32_t numberOf(std::uint64_t key);

    const KeyIndex* blocks = nullptr;
    std::vector<BlockPassage> passages;
    std::vector<std::uint64_t> new_blocks;  // keys of those that have no number yet
    std::vector<std::uint16_t> voxels;
    std::size_t used = 0;  // of voxels
    std::uint64_t last_key = NOWHERE;
    std::uint32_t last = KeyIndex::NONE;
  };

  std::vector<List> lists_;
};

}  // namespace mesh_map
