#include "spatial/device_queries.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <stdexcept>
#include <utility>

#include "threads/cancellation.h"

namespace rviz_mesh_plugin {

using mesh_map::BvhOptions;

namespace {

constexpr std::size_t SLOTS = 2;

/// Rays at once: tens of milliseconds of work, so that cancelling takes no longer.
std::size_t chunkSize(const OpenClProgram& program)
{
  return program.info.type == DeviceType::GPU ? std::size_t(1) << 18 : std::size_t(1) << 16;
}

std::size_t groupSize(const OpenClProgram& program)
{
  return std::min(mesh_map::DEVICE_WORK_GROUP, program.max_work_group);
}

/// Commands under way, which have ended when this goes, whatever is thrown meanwhile: what they
/// read and write stays until then.
class DeviceCommands
{
 public:
  DeviceCommands() = default;
  ~DeviceCommands()
  {
    try {
      wait();
    } catch (const cl::Error&) {
      return;  // the device is lost, and with it the commands
    }
  }
  DeviceCommands(const DeviceCommands&) = delete;
  DeviceCommands& operator=(const DeviceCommands&) = delete;

  /// For one call that enqueues a command: MAX of them before wait().
  cl::Event* add() { return &events_.at(count_++); }

  /// Throws cl::Error if one of them broke off.
  void wait()
  {
    std::array<cl_event, MAX> accepted{};
    cl_uint count = 0;
    for (std::size_t i = 0; i < count_; ++i) {
      if (events_[i]() != nullptr) {
        accepted[count++] = events_[i]();
      }
    }
    count_ = 0;
    const cl_int status = count > 0 ? ::clWaitForEvents(count, accepted.data()) : CL_SUCCESS;
    events_ = {};
    if (status != CL_SUCCESS) {
      throw cl::Error(status, "clWaitForEvents");
    }
  }

 private:
  static constexpr std::size_t MAX = 3;
  std::array<cl::Event, MAX> events_;  // no allocation can fail between a command and its event
  std::size_t count_ = 0;
};

/// Work items of a kernel side by side, the same number for every launch: some drivers compile it
/// once for each.
cl::NDRange workGroup(const OpenClProgram& program)
{
  return cl::NDRange(groupSize(program));
}

/// At least `count` work items, in whole work groups.
cl::NDRange workItems(const OpenClProgram& program, std::size_t count)
{
  const std::size_t group = groupSize(program);
  return cl::NDRange((count + group - 1) / group * group);
}

std::size_t nodeBytes(const mesh_map::Bvh& bvh)
{
  return bvh.nodes().size() * sizeof(mesh_map::BvhNode);
}

std::size_t cornerCount(const mesh_map::Bvh& bvh)
{
  return bvh.corners().size() + mesh_map::Bvh::TAIL;
}

/// What a batch takes of the device per ray: more than the kernel needs.
constexpr std::size_t BYTES_PER_RAY = 128;

template <class... Arguments>
cl::Kernel makeKernel(const OpenClProgram& program, const char* name, const Arguments&... arguments)
{
  cl::Kernel kernel(program.program, name);
  cl_uint index = 0;
  (kernel.setArg(index++, arguments), ...);
  return kernel;
}

template <class T>
cl::Buffer upload(const OpenClProgram& program, const T* values, std::size_t count)
{
  return cl::Buffer(program.context, CL_MEM_READ_ONLY | CL_MEM_COPY_HOST_PTR, count * sizeof(T),
                    const_cast<T*>(values));
}

/// A chunk of a batch of rays on its way.
class Slot
{
 public:
  bool busy() const { return rays_.size() > 0; }

  /// @param kernel makes one with its arguments for the packed rays, their number, and the answers
  template <class MakeKernel>
  void start(const OpenClProgram& program, const mesh_map::Bvh& bvh, const mesh_map::RayBatch& rays,
             const BvhOptions& run, const MakeKernel& kernel)
  {
    packed_ = mesh_map::packRays(bvh, rays, run);
    answers_.resize(rays.size() * mesh_map::DEVICE_RAY_ANSWERS);
    const std::size_t packed_bytes = packed_.size() * sizeof(float);
    const std::size_t answer_bytes = answers_.size() * sizeof(std::uint32_t);
    if (packed_bytes > capacity_) {
      packed_buffer_ = cl::Buffer(program.context, CL_MEM_READ_ONLY, packed_bytes);
      answer_buffer_ = cl::Buffer(program.context, CL_MEM_WRITE_ONLY, answer_bytes);
      capacity_ = packed_bytes;
    }
    const cl::Kernel cast = kernel(packed_buffer_, rays.size(), answer_buffer_);
    const cl::CommandQueue& queue = program.queue;
    queue.enqueueWriteBuffer(packed_buffer_, CL_FALSE, 0, packed_bytes, packed_.data(), nullptr,
                             commands_.add());
    queue.enqueueNDRangeKernel(cast, cl::NullRange, workItems(program, rays.size()),
                               workGroup(program), nullptr, commands_.add());
    queue.enqueueReadBuffer(answer_buffer_, CL_FALSE, 0, answer_bytes, answers_.data(), nullptr,
                            commands_.add());
    queue.flush();
    rays_ = rays;
  }

  mesh_map::RayHits finish(const mesh_map::Bvh& bvh, const BvhOptions& run)
  {
    commands_.wait();
    return mesh_map::finishRays(bvh, std::exchange(rays_, {}), {}, answers_, run);
  }

 private:
  mesh_map::RayBatch rays_;
  std::vector<float> packed_;
  std::vector<std::uint32_t> answers_;
  cl::Buffer packed_buffer_, answer_buffer_;
  std::size_t capacity_ = 0;
  DeviceCommands commands_;  // the last: ends before what it reads and writes
};

}  // namespace

std::string DeviceQueries::refusal(const OpenClProgram& program, const mesh_map::Bvh& bvh)
{
  const std::size_t nodes = nodeBytes(bvh), corners = cornerCount(bvh) * sizeof(float);
  const std::size_t needed =
      nodes + corners + 2 * bvh.faceCount() + SLOTS * chunkSize(program) * BYTES_PER_RAY;
  if (std::max(nodes, corners) <= program.max_buffer && needed <= program.memory) {
    return "";
  }
  return "a mesh of " + std::to_string(bvh.faceCount()) + " faces needs buffers of " +
         std::to_string(std::max(nodes, corners) >> 20) + " MB and " +
         std::to_string(needed >> 20) + " MB in all, but " + program.info.text() + " has " +
         std::to_string(program.max_buffer >> 20) + " MB and " +
         std::to_string(program.memory >> 20) + " MB";
}

DeviceQueries::DeviceQueries(std::shared_ptr<const OpenClProgram> program, const mesh_map::Bvh& bvh)
    : program_(std::move(program)), bvh_(bvh)
{
  const auto memory = [&](const void* data, std::size_t bytes) {
    const cl_mem_flags where =
        program_->info.type == DeviceType::CPU ? CL_MEM_USE_HOST_PTR : CL_MEM_COPY_HOST_PTR;
    return cl::Buffer(program_->context, CL_MEM_READ_ONLY | where, bytes, const_cast<void*>(data));
  };
  nodes_ = memory(bvh.nodes().data(), nodeBytes(bvh));
  corners_ = memory(bvh.corners().data(), cornerCount(bvh) * sizeof(float));
}

void DeviceQueries::castRays(const mesh_map::RayBatch& rays, const BvhOptions& run,
                             mesh_map::RayHits& hits) const
{
  const std::uint8_t no_mask = 1;
  const cl::Buffer mask = upload(*program_, &no_mask, 1);
  const auto kernel = [&](const cl::Buffer& packed, std::size_t count, const cl::Buffer& answers) {
    return makeKernel(*program_, "cast_rays", nodes_, corners_, packed, mask,
                      cl_uint{mesh_map::DEVICE_BACK_FACES}, static_cast<cl_uint>(count), answers);
  };
  std::array<Slot, SLOTS> slots;
  const auto finish = [&](Slot& slot) {
    if (slot.busy()) {
      append(hits, slot.finish(bvh_, run));
    }
    throwIfCanceled(run.cancel);
  };
  // While the device has a chunk, the host finishes the one before and packs the next.
  const std::size_t count = rays.size(), size = chunkSize(*program_);
  std::size_t chunk = 0;
  for (std::size_t begin = 0; begin < count; begin += size, ++chunk) {
    Slot& next = slots[chunk % SLOTS];
    finish(next);
    next.start(*program_, bvh_, slice(rays, begin, std::min(count, begin + size)), run, kernel);
  }
  for (std::size_t i = 0; i < SLOTS; ++i, ++chunk) {
    finish(slots[chunk % SLOTS]);
  }
}

std::vector<std::uint32_t> DeviceQueries::selectFaces(const mesh_map::Region& region,
                                                      const std::vector<std::uint32_t>& roots,
                                                      const BvhOptions& run) const
{
  std::vector<std::uint8_t> verdicts(bvh_.faceCount(), mesh_map::DEVICE_OUTSIDE);
  if (!roots.empty()) {
    const auto* sphere = dynamic_cast<const mesh_map::SphereRegion*>(&region);
    const auto* convex = dynamic_cast<const mesh_map::ConvexRegion*>(&region);
    if (!sphere && !convex) {
      throw std::invalid_argument("devices select by spheres and planes only");
    }
    const auto numbers =
        sphere ? mesh_map::packSphere(bvh_, *sphere) : mesh_map::packPlanes(bvh_, *convex);
    const cl::Buffer region_buffer = upload(*program_, numbers.data(), numbers.size());
    const cl::Buffer root_buffer = upload(*program_, roots.data(), roots.size());
    const cl::Buffer verdict_buffer(program_->context, CL_MEM_READ_WRITE | CL_MEM_COPY_HOST_PTR,
                                    verdicts.size(), verdicts.data());
    const std::size_t count = roots.size() / 2;
    const auto root_count = static_cast<cl_uint>(count);
    const cl::Kernel kernel =
        sphere ? makeKernel(*program_, "select_sphere", nodes_, corners_, region_buffer,
                            root_buffer, root_count, verdict_buffer)
               : makeKernel(*program_, "select_planes", nodes_, corners_, region_buffer,
                            static_cast<cl_uint>(convex->planes().size()), root_buffer, root_count,
                            verdict_buffer);
    DeviceCommands commands;
    program_->queue.enqueueNDRangeKernel(kernel, cl::NullRange, workItems(*program_, count),
                                         workGroup(*program_), nullptr, commands.add());
    program_->queue.enqueueReadBuffer(verdict_buffer, CL_FALSE, 0, verdicts.size(), verdicts.data(),
                                      nullptr, commands.add());
    commands.wait();
  }
  return mesh_map::finishSelection(bvh_, region, mesh_map::SelectionMode::TOUCHING, {}, verdicts,
                                   run);
}

}  // namespace rviz_mesh_plugin
