#pragma once

#include <mesh_map/array_view.h>
#include <mesh_map/bvh.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "rviz_mesh_plugin/opencl_program.h"

namespace rviz_mesh_plugin {

/// Items of work that a kernel does, each on its own, and how to make and to use them.
struct DeviceBatch
{
  std::size_t count = 0;
  std::size_t answers_per_item = 0;
  std::function<std::vector<float>(std::size_t begin, std::size_t end)> pack;
  /// Makes a kernel with its arguments for `count` items.
  std::function<cl::Kernel(const cl::Buffer& items, std::size_t count, const cl::Buffer& answers)>
      kernel;
  std::function<void(std::size_t begin, std::size_t end, mesh_map::ArrayView<std::uint32_t>)>
      finish;
};

/// Commands under way, which have ended when this goes, whatever is thrown meanwhile: what they
/// read and write stays until then.
class DeviceCommands
{
 public:
  DeviceCommands() = default;
  ~DeviceCommands();
  DeviceCommands(const DeviceCommands&) = delete;
  DeviceCommands& operator=(const DeviceCommands&) = delete;

  /// For one call that enqueues a command: MAX of them before wait().
  cl::Event* add();

  /// Throws cl::Error if one of them broke off.
  void wait();

 private:
  static constexpr std::size_t MAX = 3;
  std::array<cl::Event, MAX> events_;  // no allocation can fail between a command and its event
  std::size_t count_ = 0;
};

/// Work items of a kernel side by side, the same number for every launch: some drivers compile it
/// once for each.
cl::NDRange workGroup(const OpenClProgram& program);

/// At least `count` work items, in whole work groups.
cl::NDRange workItems(const OpenClProgram& program, std::size_t count);

/// Runs a batch chunk by chunk, in order. While the device has one, the host finishes the one
/// before and packs the next. Throws cl::Error, Cancelled, or what `pack` and `finish` throw; items
/// finished by then stay so, and nothing runs on.
void runBatch(const OpenClProgram& program, const DeviceBatch& batch,
              const mesh_map::BvhOptions& run);

/// Bytes of the device that runBatch() takes at most.
std::size_t batchMemory(const OpenClProgram& program, std::size_t bytes_per_item);

}  // namespace rviz_mesh_plugin
