#include "reconstruction/block_passages.h"

#include <algorithm>

namespace mesh_map {
namespace {

constexpr std::size_t USUAL_PASSAGES = 4, USUAL_VOXELS = 20;  // of a ray
constexpr std::uint32_t MANY = 256;                           // passages of a block
constexpr std::size_t AHEAD = 8;  // rays whose normals are on the way from memory

Vector3f inBlocks(const Vector3f& at)
{
  constexpr float BLOCKS = 1.0f / BLOCK_SIDE;
  return {at[0] * BLOCKS, at[1] * BLOCKS, at[2] * BLOCKS};
}

}  // namespace

void PassageLists::list(std::size_t number, MeasuredRays& rays, const SurfaceNormals& normals,
                        const std::vector<std::uint32_t>& cells, const KeyIndex& blocks, bool carve)
{
  const std::size_t end = std::min(rays.size(), (number + 1) * RAYS);
  List list(blocks);  // of this thread alone, until it is done
  for (std::size_t i = number * RAYS; i < end; ++i) {
    if (cells[i] == SurfaceNormals::NO_CELL) {
      continue;
    }
    if (i + AHEAD < end && cells[i + AHEAD] != SurfaceNormals::NO_CELL) {
      __builtin_prefetch(&normals.at(cells[i + AHEAD]));
    }
    const RayParts parts = rays.aim(i, normals.at(cells[i]));
    const auto ray = static_cast<std::uint32_t>(i);
    list.add(CellWalk(parts.front, parts.back), ray);
    if (parts.is_grazing) {
      list.add(CellWalk(parts.outside, parts.inside), ray);
    }
    if (carve) {
      list.addCarved(CellWalk(inBlocks(rays.sensor(i)), inBlocks(parts.front)), ray);
    }
  }
  lists_[number] = std::move(list);
}

PassageLists::List::List(const KeyIndex& blocks) : blocks(&blocks), voxels(USUAL_VOXELS * RAYS)
{
  passages.reserve(USUAL_PASSAGES * RAYS);
}

void PassageLists::List::add(const CellWalk& walk, std::uint32_t ray)
{
  const std::size_t most = used + walk.count() + PADDING;
  if (voxels.size() < most) {
    voxels.resize(std::max(2 * voxels.size(), most));
  }
  std::uint16_t* const begin = voxels.data();
  std::uint16_t* at = begin + used;
  std::uint64_t block = NOWHERE;
  const auto close = [this, begin, &at] {
    const auto end = static_cast<std::size_t>(at - begin);
    passages.back().count = static_cast<std::uint32_t>(end - used);
    used = end;
  };
  walk.each([&](std::uint64_t voxel) {
    if ((voxel & ~WITHIN_BLOCK) != block) {
      if (block != NOWHERE) {
        close();
      }
      block = voxel & ~WITHIN_BLOCK;
      BlockPassage& passage = passages.emplace_back();
      passage.block = numberOf(blockOf(voxel));
      passage.ray = ray;
      passage.first = static_cast<std::uint32_t>(used);
    }
    *at++ = static_cast<std::uint16_t>(voxelInBlock(voxel));
  });
  close();
}

void PassageLists::List::addCarved(const CellWalk& walk, std::uint32_t ray)
{
  walk.each([this, ray](std::uint64_t key) {
    const std::uint32_t block = blocks->find(key);
    if (block != KeyIndex::NONE) {
      passages.push_back({nullptr, block, ray, 0, 0});
    }
  });
}

std::uint32_t PassageLists::List::numberOf(std::uint64_t key)
{
  if (key != last_key) {
    last_key = key;
    last = blocks->find(key);
  }
  if (last == KeyIndex::NONE) {
    new_blocks.push_back(key);
  }
  return last;
}

std::vector<BlockPassages> PassageLists::byBlock(KeyIndex& blocks,
                                                 const std::function<void()>& added)
{
  std::vector<BlockPassages> all;
  std::vector<std::uint32_t> places(blocks.size(), KeyIndex::NONE);  // in `all`
  for (List& list : lists_) {
    auto new_block = list.new_blocks.begin();
    for (BlockPassage& passage : list.passages) {
      if (passage.block == KeyIndex::NONE) {
        passage.block = blocks.add(*new_block++);
        if (passage.block == places.size()) {
          places.push_back(KeyIndex::NONE);
          added();
        }
      }
      std::uint32_t& place = places[passage.block];
      if (place == KeyIndex::NONE) {
        place = static_cast<std::uint32_t>(all.size());
        all.push_back({passage.block, 0, &passage, nullptr});
      } else {
        all[place].last->next = &passage;
      }
      all[place].last = &passage;
      ++all[place].count;
    }
  }
  std::partition(all.begin(), all.end(), [](const BlockPassages& one) { return one.count > MANY; });
  return all;
}

}  // namespace mesh_map
