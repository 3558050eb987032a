// Buffers of fronts, which are used again: what a front has not touched is as it was.

#include <mesh_map/wave_front.h>

#include <algorithm>
#include <utility>

#include "wave_front_buffers.h"
#include "wave_front_triangle.h"

namespace mesh_map {
namespace {

/// More than this are not kept for later.
constexpr std::size_t MAX_SPARE = 4;

}  // namespace

WaveFrontPool::WaveFrontPool(std::shared_ptr<const FrontMesh> mesh) : mesh_(std::move(mesh)) {}

WaveFrontPool::~WaveFrontPool() = default;

std::unique_ptr<WaveFrontBuffers> WaveFrontPool::take()
{
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!spare_.empty()) {
      std::unique_ptr<WaveFrontBuffers> buffers = std::move(spare_.back());
      spare_.pop_back();
      return buffers;
    }
  }
  auto buffers = std::make_unique<WaveFrontBuffers>();
  buffers->labels.assign(mesh_->vertexCount(), NOT_REACHED);
  return buffers;
}

void WaveFrontPool::giveBack(std::unique_ptr<WaveFrontBuffers> buffers)
{
  buffers->clear();
  const std::lock_guard<std::mutex> lock(mutex_);
  if (spare_.size() < MAX_SPARE) {
    spare_.push_back(std::move(buffers));
  }
}

void WaveFrontBuffers::clear()
{
  if (touched.size() > labels.size() / 4) {
    std::fill(labels.begin(), labels.end(), NOT_REACHED);
  } else {
    for (const std::uint32_t v : touched) {
      labels[v] = NOT_REACHED;
    }
  }
  touched.clear();
  tasks.clear();
  is_in_repair = false;
  queue.reset(queue.width());
}

}  // namespace mesh_map
