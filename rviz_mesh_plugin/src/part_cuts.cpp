#include "rviz_mesh_plugin/part_cuts.h"

#include <mesh_map/parallel.h>

#include <algorithm>
#include <array>
#include <limits>

namespace rviz_mesh_plugin {
namespace {

/// Faces are cut between blocks of so many.
constexpr std::size_t BLOCK_FACES = 128;
/// This many times a usual step.
constexpr float FAR = 16.0f;
constexpr std::size_t SAMPLES = 20000;
/// A cut that leaves less than this part of the cost parts strays from the rest.
constexpr float STRAY_GAIN = 0.25f;

struct Box
{
  std::array<float, 3> lower;
  std::array<float, 3> upper;

  Box()
  {
    lower.fill(std::numeric_limits<float>::max());
    upper.fill(std::numeric_limits<float>::lowest());
  }

  void enclose(const std::array<float, 3>& least, const std::array<float, 3>& greatest)
  {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      lower[axis] = std::min(lower[axis], least[axis]);
      upper[axis] = std::max(upper[axis], greatest[axis]);
    }
  }

  /// Grows with the chance that a camera sees the box; not 0 for flat ones.
  float size() const
  {
    return (upper[0] - lower[0]) + (upper[1] - lower[1]) + (upper[2] - lower[2]);
  }
};

class Cutter
{
 public:
  Cutter(const SplitFaces& faces, const std::vector<MeshVertex>& vertices)
      : faces_(faces), vertices_(vertices), count_(faces.indices.size() / 3)
  {
  }

  std::vector<std::size_t> cut()
  {
    makeBlocks();
    for (std::size_t first = 0; first < boxes_.size();) {
      std::size_t last = first + 1;
      while (last < boxes_.size() && material(last) == material(first)) {
        ++last;
      }
      cutBlocks(first, last);
      first = last;
    }
    cuts_.push_back(count_);
    return cuts_;
  }

 private:
  std::uint32_t material(std::size_t block) const
  {
    return faces_.materials.empty() ? NONE : faces_.materials[begins_[block]];
  }

  const std::array<float, 3>& position(std::size_t index) const
  {
    return vertices_[faces_.indices[index]].position;
  }

  /// Blocks end where the material changes, and where the next face is far, too.
  void makeBlocks()
  {
    const float far = farStep();
    for (std::size_t face = 0; face < count_; ++face) {
      if (face == 0 || face - begins_.back() == BLOCK_FACES ||
          (!faces_.materials.empty() && faces_.materials[face] != faces_.materials[face - 1]) ||
          squaredStep(face) > far) {
        begins_.push_back(face);
      }
    }
    boxes_.resize(begins_.size());
    begins_.push_back(count_);
    mesh_map::parallelFor(boxes_.size(), BLOCK_FACES, 0, [this]() -> mesh_map::RangeBody {
      return [this](std::size_t first, std::size_t last) {
        for (std::size_t block = first; block < last; ++block) {
          Box box;
          for (std::size_t i = 3 * begins_[block]; i < 3 * begins_[block + 1]; ++i) {
            box.enclose(position(i), position(i));
          }
          boxes_[block] = box;
        }
      };
    });
  }

  /// Squared, to a face from the one before.
  float squaredStep(std::size_t face) const
  {
    const auto& a = position(3 * face - 3);
    const auto& b = position(3 * face);
    const float x = a[0] - b[0];
    const float y = a[1] - b[1];
    const float z = a[2] - b[2];
    return x * x + y * y + z * z;
  }

  /// A step that is far, squared, judged by samples: a block with one would have a large box.
  float farStep() const
  {
    std::vector<float> steps;
    const std::size_t stride = std::max<std::size_t>(1, count_ / SAMPLES);
    for (std::size_t face = 1; face < count_; face += stride) {
      steps.push_back(squaredStep(face));
    }
    if (steps.empty()) {
      return 0.0f;
    }
    std::nth_element(steps.begin(), steps.begin() + steps.size() / 2, steps.end());
    return FAR * FAR * steps[steps.size() / 2];
  }

  std::size_t facesOf(std::size_t first, std::size_t last) const
  {
    return begins_[last] - begins_[first];
  }

  /// Halves the blocks [first, last) where that makes the smallest boxes, until they are few.
  void cutBlocks(std::size_t first, std::size_t last)
  {
    const std::size_t count = last - first;
    std::vector<float> costs(count, 0.0f);  // of a cut before each block
    Box box;
    for (std::size_t i = count; i-- > 1;) {
      box.enclose(boxes_[first + i].lower, boxes_[first + i].upper);
      costs[i] = box.size() * static_cast<float>(facesOf(first + i, last));
    }
    box = Box();
    for (std::size_t i = 1; i < count; ++i) {
      box.enclose(boxes_[first + i - 1].lower, boxes_[first + i - 1].upper);
      costs[i] += box.size() * static_cast<float>(facesOf(first, first + i));
    }
    box.enclose(boxes_[last - 1].lower, boxes_[last - 1].upper);
    const float whole = box.size() * static_cast<float>(facesOf(first, last));
    std::size_t best = bestCut(costs, 1, count);
    if (count == 1 || !(costs[best] < STRAY_GAIN * whole)) {
      if (facesOf(first, last) <= PART_FACES) {
        cuts_.push_back(begins_[first]);
        return;
      }
      best = bestCut(costs, (count + 7) / 8, count - count / 8);
    }
    cutBlocks(first, first + best);
    cutBlocks(first + best, last);
  }

  /// Of equal ones the one next to the middle.
  static std::size_t bestCut(const std::vector<float>& costs, std::size_t begin, std::size_t end)
  {
    const std::size_t middle = costs.size() / 2;
    std::size_t best = middle;
    for (std::size_t i = begin; i < end; ++i) {
      best = costs[i] < costs[best] ? i : best;
    }
    return best;
  }

  const SplitFaces& faces_;
  const std::vector<MeshVertex>& vertices_;
  std::size_t count_;
  std::vector<std::size_t> begins_;  ///< first face of each block, and the end
  std::vector<Box> boxes_;
  std::vector<std::size_t> cuts_;
};

}  // namespace

std::vector<std::size_t> cutIntoParts(const SplitFaces& faces,
                                      const std::vector<MeshVertex>& vertices)
{
  return Cutter(faces, vertices).cut();
}

}  // namespace rviz_mesh_plugin
