#include "bvh/device/device_frame.h"

#include <algorithm>
#include <stdexcept>
#include <string>

namespace mesh_map {

static_assert(BVH_STACK <= 128 && BVH_WIDTH == 4 && BVH_LEAF_SIZE == 4, "kernels/bvh.cl says so");
static_assert(Bvh::TAIL >= 9 * (BVH_LEAF_SIZE - 1), "kernels read whole leaves");

const char* const BVH_KERNEL_OPTIONS = "-cl-std=CL1.2";

DeviceFrame::DeviceFrame(const Bvh& bvh)
{
  for (std::size_t k = 0; k < 3; ++k) {
    center[k] = bvh.center()[k];
    lower[k] = bvh.lower()[k];
    upper[k] = bvh.upper()[k];
    reach[k] = std::max(std::abs(lower[k]), std::abs(upper[k]));
    size = std::max(size, upper[k] - lower[k]);
    usable = usable && reach[k] <= DEVICE_LARGEST;
  }
}

void checkAnswers(std::size_t answers, std::size_t count, std::size_t per_item)
{
  if (answers != count * per_item) {
    throw std::invalid_argument(std::to_string(answers) + " answers of a device do not fit " +
                                std::to_string(count) + " queries: " + std::to_string(per_item) +
                                " for each");
  }
}

std::vector<std::uint8_t> deviceMask(const Bvh& bvh, ArrayView<std::uint8_t> mask)
{
  checkMask(bvh, mask);
  std::vector<std::uint8_t> result(mask.size());
  for (std::size_t i = 0; i < mask.size(); ++i) {
    result[i] = mask[bvh.faces()[i]];
  }
  return result;
}

}  // namespace mesh_map
