#include "reconstruction/surface_extraction.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/run.h"
#include "reconstruction/marching_cubes.h"

namespace mesh_map {
namespace {

constexpr std::uint32_t BLOCK_SHIFT = 11;  // of which block, in a corner; below: 3 * voxel + axis
constexpr std::int32_t SEARCHED = 4;       // voxels around, where no ray ended near a vertex
constexpr float NEAREST = 0.02f;           // voxels from an end of its edge to a vertex
constexpr std::size_t CHUNK = 16;          // blocks that a thread takes at a time

/// Bits of an edge in its set.
std::uint64_t bitOf(std::size_t edge)
{
  return std::uint64_t{1} << (edge % 64);
}

std::size_t countBits(std::uint64_t bits)
{
  return static_cast<std::size_t>(__builtin_popcountll(bits));
}

/// The values around a block: voxels from -MARGIN to BLOCK_SIDE + MARGIN - 1 along each axis.
template <int MARGIN_LOW, int MARGIN_HIGH>
class Surroundings
{
 public:
  static constexpr std::int32_t SIDE = BLOCK_SIDE + MARGIN_LOW + MARGIN_HIGH;

  /// A place in the arrays, of a voxel as seen from the block.
  static constexpr std::size_t at(std::int32_t x, std::int32_t y, std::int32_t z)
  {
    return static_cast<std::size_t>(x + MARGIN_LOW +
                                    SIDE * (y + MARGIN_LOW + SIDE * (z + MARGIN_LOW)));
  }
  static constexpr std::array<std::size_t, 3> STEPS = {1, static_cast<std::size_t>(SIDE),
                                                       static_cast<std::size_t>(SIDE* SIDE)};

  /// Distances as shares of the truncation; NaN where the weight is below the least.
  Surroundings(const VoxelBlocks& blocks, const GridPlace& place, std::uint16_t least)
  {
    values.fill(std::numeric_limits<float>::quiet_NaN());
    for (std::int32_t bz = -(MARGIN_LOW > 0); bz <= 1; ++bz) {
      for (std::int32_t by = -(MARGIN_LOW > 0); by <= 1; ++by) {
        for (std::int32_t bx = -(MARGIN_LOW > 0); bx <= 1; ++bx) {
          const VoxelBlock* const block = blocks.at(place + GridPlace{bx, by, bz});
          if (block != nullptr) {
            take(*block, {bx, by, bz}, least);
          }
        }
      }
    }
  }

  std::array<float, static_cast<std::size_t>(SIDE* SIDE* SIDE)> values;

 private:
  /// The voxels of a block on one side, as far as they are within the margins.
  static std::pair<std::int32_t, std::int32_t> rangeOf(std::int32_t side)
  {
    return side < 0   ? std::pair{BLOCK_SIDE - MARGIN_LOW, BLOCK_SIDE}
           : side > 0 ? std::pair{0, MARGIN_HIGH}
                      : std::pair{0, BLOCK_SIDE};
  }

  void take(const VoxelBlock& block, const std::array<std::int32_t, 3>& beside, std::uint16_t least)
  {
    const auto [x0, x1] = rangeOf(beside[0]);
    const auto [y0, y1] = rangeOf(beside[1]);
    const auto [z0, z1] = rangeOf(beside[2]);
    for (std::int32_t z = z0; z < z1; ++z) {
      for (std::int32_t y = y0; y < y1; ++y) {
        for (std::int32_t x = x0; x < x1; ++x) {
          const std::size_t voxel = voxelInBlock(x, y, z);
          if (block.distances[voxel].weight() >= least) {
            values[at(x + BLOCK_SIDE * beside[0], y + BLOCK_SIDE * beside[1],
                      z + BLOCK_SIDE * beside[2])] =
                static_cast<float>(block.distances[voxel].distance()) * (1 / DISTANCE_UNITS);
          }
        }
      }
    }
  }
};

/// Means of what rays that ended near some voxels measured.
struct SeenVoxels
{
  float weight = 0, intensities = 0;
  std::array<float, 3> colors = {0, 0, 0};

  void add(const VoxelBlock& block, std::size_t voxel, float share)
  {
    if (!(share > 0)) {
      return;
    }
    weight += share;
    if (block.intensities) {
      intensities += share * (*block.intensities)[voxel];
    }
    if (block.colors) {
      const VoxelColor& color = (*block.colors)[voxel];
      colors[0] += share * color.red;
      colors[1] += share * color.green;
      colors[2] += share * color.blue;
    }
  }

  /// Those in a box around a voxel of a block, which need not be in that block.
  void addAround(const VoxelBlocks& blocks, const GridPlace& place,
                 const std::array<std::int32_t, 3>& voxel, std::int32_t reach)
  {
    for (std::int32_t z = voxel[2] - reach; z <= voxel[2] + reach; ++z) {
      for (std::int32_t y = voxel[1] - reach; y <= voxel[1] + reach; ++y) {
        for (std::int32_t x = voxel[0] - reach; x <= voxel[0] + reach; ++x) {
          // From -BLOCK_SIDE on, so that these divisions round down.
          const GridPlace beside = {(x + BLOCK_SIDE) / BLOCK_SIDE - 1,
                                    (y + BLOCK_SIDE) / BLOCK_SIDE - 1,
                                    (z + BLOCK_SIDE) / BLOCK_SIDE - 1};
          const VoxelBlock* const block = blocks.at(place + beside);
          if (block != nullptr) {
            const std::size_t at =
                voxelInBlock((x + BLOCK_SIDE) % BLOCK_SIDE, (y + BLOCK_SIDE) % BLOCK_SIDE,
                             (z + BLOCK_SIDE) % BLOCK_SIDE);
            add(*block, at, block->observations[at] > 0 ? 1.0f : 0.0f);
          }
        }
      }
    }
  }

  float intensity() const { return weight > 0 ? intensities / weight : 0; }
  std::array<std::uint8_t, 3> color() const
  {
    std::array<std::uint8_t, 3> mean{};
    for (std::size_t k = 0; k < 3 && weight > 0; ++k) {
      mean[k] = static_cast<std::uint8_t>(std::lrint(colors[k] / weight));
    }
    return mean;
  }
};

std::uint16_t leastUnits(float least_weight)
{
  return static_cast<std::uint16_t>(
      std::clamp(std::ceil(least_weight * WEIGHT_UNITS), 1.0f, 65535.0f));
}

}  // namespace

FieldSurface SurfaceExtraction::extract(SignedDistanceField& field, float least_weight,
                                        const BvhOptions& options)
{
  Run run(options);
  run.check();
  VoxelBlocks& blocks = field.blocks();
  const std::size_t count = blocks.blocks.size();
  const bool all = least_weight != least_weight_;
  surfaces_.resize(count);

  // What has to be made anew: triangles of blocks that use a value that changed, and vertices of
  // those that have an edge there, or a gradient.
  std::vector<std::uint8_t> near_change(count, all ? 1 : 0);
  for (std::size_t i = 0; i < count && !all; ++i) {
    if (blocks.blocks[i] != nullptr && blocks.blocks[i]->is_changed) {
      const GridPlace place = GridPlace::of(blocks.index.keys()[i]);
      for (std::int32_t k = 0; k < 27; ++k) {
        const GridPlace beside = place + GridPlace{k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1};
        const std::uint32_t number =
            beside.isInside() ? blocks.index.find(beside.key()) : KeyIndex::NONE;
        if (number < count) {
          near_change[number] = 1;
        }
      }
    }
  }
  std::vector<std::uint32_t> anew;
  for (std::uint32_t i = 0; i < count; ++i) {
    if (near_change[i] != 0 && blocks.blocks[i] != nullptr) {
      anew.push_back(i);
    }
  }
  least_weight_ = -1;  // until all is done
  run.each(anew.size(), CHUNK, 0.5,
           [&](std::size_t i) { makeTriangles(blocks, anew[i], least_weight); });
  run.each(anew.size(), CHUNK, 0.4, [&](std::size_t i) { makeVertices(field, anew[i]); });
  run.check();
  least_weight_ = least_weight;
  for (const auto& block : blocks.blocks) {
    if (block != nullptr) {
      block->is_changed = false;
    }
  }

  std::size_t vertex_count = 0;
  std::vector<std::size_t> first_corner(count + 1, 0);
  for (std::size_t i = 0; i < count; ++i) {
    surfaces_[i].first = vertex_count;
    vertex_count += surfaces_[i].vertices.size();
    first_corner[i + 1] = first_corner[i] + surfaces_[i].corners.size();
  }
  const bool colors = field.options().colors, intensities = field.options().intensities;
  FieldSurface surface;
  surface.vertices.resize(3 * vertex_count);
  surface.normals.resize(3 * vertex_count);
  surface.observations.resize(vertex_count);
  surface.colors.resize(colors ? 3 * vertex_count : 0);
  surface.intensities.resize(intensities ? vertex_count : 0);
  surface.faces.resize(first_corner[count]);
  run.each(count, CHUNK, 0.1, [&](std::size_t i) {
    const BlockSurface& own = surfaces_[i];
    std::size_t at = own.first;
    for (const BlockSurface::Vertex& vertex : own.vertices) {
      std::copy_n(vertex.position.begin(), 3, surface.vertices.begin() + 3 * at);
      std::copy_n(vertex.normal.begin(), 3, surface.normals.begin() + 3 * at);
      surface.observations[at] = vertex.observations;
      if (colors) {
        std::copy_n(vertex.color.begin(), 3, surface.colors.begin() + 3 * at);
      }
      if (intensities) {
        surface.intensities[at] = vertex.intensity;
      }
      ++at;
    }
    const GridPlace place = GridPlace::of(blocks.index.keys()[i]);
    std::array<const BlockSurface*, 8> owners;
    std::array<std::array<std::uint32_t, EDGES / 64>, 8> before;  // vertices before these of a word
    for (std::int32_t k = 0; k < 8 && !own.corners.empty(); ++k) {
      const GridPlace beside = place + GridPlace{k & 1, (k >> 1) & 1, k >> 2};
      const std::uint32_t number =
          beside.isInside() ? blocks.index.find(beside.key()) : KeyIndex::NONE;
      owners[k] = number < count ? &surfaces_[number] : nullptr;
      if (owners[k] != nullptr) {
        auto sum = static_cast<std::uint32_t>(owners[k]->first);
        for (std::size_t word = 0; word < EDGES / 64; ++word) {
          before[k][word] = sum;
          sum += static_cast<std::uint32_t>(countBits(owners[k]->used[word]));
        }
      }
    }
    for (std::size_t k = 0; k < own.corners.size(); ++k) {
      const std::uint32_t corner = own.corners[k], edge = corner & ((1u << BLOCK_SHIFT) - 1);
      const std::uint32_t which = corner >> BLOCK_SHIFT;
      const std::uint64_t below = owners[which]->used[edge / 64] & (bitOf(edge) - 1);
      surface.faces[first_corner[i] + k] =
          before[which][edge / 64] + static_cast<std::uint32_t>(countBits(below));
    }
  });
  return surface;
}

void SurfaceExtraction::makeTriangles(const VoxelBlocks& blocks, std::uint32_t number,
                                      float least_weight)
{
  const GridPlace place = GridPlace::of(blocks.index.keys()[number]);
  const Surroundings<0, 1> around(blocks, place, leastUnits(least_weight));
  BlockSurface& surface = surfaces_[number];
  surface.corners.clear();
  std::array<std::size_t, 8> offsets;
  for (int c = 0; c < 8; ++c) {
    offsets[c] = around.at(c & 1, (c >> 1) & 1, c >> 2);
  }
  for (std::int32_t z = 0; z < BLOCK_SIDE; ++z) {
    for (std::int32_t y = 0; y < BLOCK_SIDE; ++y) {
      for (std::int32_t x = 0; x < BLOCK_SIDE; ++x) {
        const float* const low = around.values.data() + around.at(x, y, z);
        unsigned inside = 0;
        float sum = 0;  // NaN where a corner is unknown
        for (unsigned c = 0; c < 8; ++c) {
          sum += low[offsets[c]];
          inside |= (low[offsets[c]] < 0 ? 1u : 0u) << c;
        }
        if (inside == 0 || inside == 255 || std::isnan(sum)) {
          continue;
        }
        for (const std::uint8_t edge : cubeTriangles(static_cast<std::uint8_t>(inside))) {
          const std::uint8_t start = edgeStart(edge);
          const std::array<std::int32_t, 3> at = {x + (start & 1), y + ((start >> 1) & 1),
                                                  z + (start >> 2)};
          const std::uint32_t block = (at[0] == BLOCK_SIDE ? 1u : 0u) |
                                      (at[1] == BLOCK_SIDE ? 2u : 0u) |
                                      (at[2] == BLOCK_SIDE ? 4u : 0u);
          const std::size_t voxel =
              voxelInBlock(at[0] % BLOCK_SIDE, at[1] % BLOCK_SIDE, at[2] % BLOCK_SIDE);
          surface.corners.push_back((block << BLOCK_SHIFT) |
                                    static_cast<std::uint32_t>(3 * voxel + edge / 4));
        }
      }
    }
  }
}

void SurfaceExtraction::makeVertices(const SignedDistanceField& field, std::uint32_t number)
{
  const VoxelBlocks& blocks = field.blocks();
  const GridPlace place = GridPlace::of(blocks.index.keys()[number]);
  BlockSurface& surface = surfaces_[number];
  surface.used.fill(0);
  surface.vertices.clear();
  bool any = false;
  for (std::int32_t k = 0; k < 8; ++k) {
    const GridPlace below = place + GridPlace{-(k & 1), -((k >> 1) & 1), -(k >> 2)};
    const std::uint32_t user = below.isInside() ? blocks.index.find(below.key()) : KeyIndex::NONE;
    if (user >= surfaces_.size()) {
      continue;
    }
    for (const std::uint32_t corner : surfaces_[user].corners) {
      if (corner >> BLOCK_SHIFT == static_cast<std::uint32_t>(k)) {
        const std::uint32_t edge = corner & ((1u << BLOCK_SHIFT) - 1);
        surface.used[edge / 64] |= bitOf(edge);
        any = true;
      }
    }
  }
  if (!any) {
    return;
  }
  using Around = Surroundings<1, 2>;
  const Around around(blocks, place, 1);
  const auto gradient = [&around](const float* value) {
    std::array<float, 3> slope;
    for (std::size_t k = 0; k < 3; ++k) {
      const float before = value[-static_cast<std::ptrdiff_t>(Around::STEPS[k])];
      const float after = value[Around::STEPS[k]];
      slope[k] = std::isnan(before)  ? (std::isnan(after) ? 0 : after - *value)
                 : std::isnan(after) ? *value - before
                                     : (after - before) / 2;
    }
    return slope;
  };
  std::array<const VoxelBlock*, 8> above{};
  for (std::int32_t k = 0; k < 8; ++k) {
    above[k] = blocks.at(place + GridPlace{k & 1, (k >> 1) & 1, k >> 2});
  }
  const double size = field.options().voxel_size;
  for (std::size_t edge = 0; edge < EDGES; ++edge) {
    if ((surface.used[edge / 64] & bitOf(edge)) == 0) {
      continue;
    }
    const std::size_t voxel = edge / 3, axis = edge % 3;
    const auto v = static_cast<std::int32_t>(voxel);
    const std::array<std::int32_t, 3> from = {v % BLOCK_SIDE, v / BLOCK_SIDE % BLOCK_SIDE,
                                              v / (BLOCK_SIDE * BLOCK_SIDE)};
    const float* const start = around.values.data() + Around::at(from[0], from[1], from[2]);
    const float* const end = start + Around::STEPS[axis];
    const float share = std::clamp(*start / (*start - *end), NEAREST, 1 - NEAREST);
    BlockSurface::Vertex vertex{};
    const std::array<std::int32_t, 3> origin = {place.x, place.y, place.z};
    const std::array<float, 3> one = gradient(start), other = gradient(end);
    float length = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const double at = origin[k] * BLOCK_SIDE + from[k] + 0.5 + (k == axis ? share : 0.0f);
      vertex.position[k] = static_cast<float>(at * size);
      vertex.normal[k] = (1 - share) * one[k] + share * other[k];
      length += vertex.normal[k] * vertex.normal[k];
    }
    for (float& component : vertex.normal) {
      component = length > 0 ? component / std::sqrt(length) : 0;
    }
    if (!(length > 0)) {  // both gradients are against each other: the edge itself is left
      vertex.normal[axis] = *start < *end ? 1.0f : -1.0f;
    }

    std::array<std::int32_t, 3> to = from;
    ++to[axis];
    const std::size_t beside = to[axis] == BLOCK_SIDE ? std::size_t{1} << axis : 0;
    to[axis] %= BLOCK_SIDE;
    const std::size_t to_voxel = voxelInBlock(to[0], to[1], to[2]);
    const VoxelBlock& a = *above[0];
    const VoxelBlock& b = *above[beside];
    const float seen_a = a.observations[voxel], seen_b = b.observations[to_voxel];
    vertex.observations = (1 - share) * seen_a + share * seen_b;
    SeenVoxels seen;
    seen.add(a, voxel, (1 - share) * std::min(seen_a, 1.0f));
    seen.add(b, to_voxel, share * std::min(seen_b, 1.0f));
    for (std::int32_t around_it = 1; around_it <= SEARCHED && seen.weight == 0; ++around_it) {
      seen.addAround(blocks, place, from, around_it);
    }
    vertex.intensity = seen.intensity();
    vertex.color = seen.color();
    surface.vertices.push_back(vertex);
  }
}

}  // namespace mesh_map
