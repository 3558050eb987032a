#include "spatial/device_queries.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <functional>
#include <stdexcept>
#include <utility>

#include "spatial/batch_slices.h"

namespace rviz_mesh_plugin {

using mesh_map::ArrayView;
using mesh_map::BvhOptions;

namespace {

constexpr std::size_t SLOTS = 2;

/// Items at once: tens of milliseconds of work, so that cancelling takes no longer.
std::size_t chunkSize(const OpenClProgram& program)
{
  return program.info.type == DeviceType::GPU ? std::size_t(1) << 18 : std::size_t(1) << 16;
}

std::size_t groupSize(const OpenClProgram& program)
{
  return std::min(mesh_map::DEVICE_WORK_GROUP, program.max_work_group);
}

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

DeviceCommands::~DeviceCommands()
{
  try {
    wait();
  } catch (const cl::Error&) {
    return;  // the device is lost, and with it the commands
  }
}

cl::Event* DeviceCommands::add()
{
  return &events_.at(count_++);
}

void DeviceCommands::wait()
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

/// Bytes of the device that runBatch() takes at most.
std::size_t batchMemory(const OpenClProgram& program, std::size_t bytes_per_item)
{
  return SLOTS * chunkSize(program) * bytes_per_item;
}

/// A chunk on its way.
class Slot
{
 public:
  bool busy() const { return end_ > begin_; }

  void start(const OpenClProgram& program, const DeviceBatch& batch, std::size_t begin,
             std::size_t end)
  {
    const std::size_t count = end - begin;
    items_ = batch.pack(begin, end);
    answers_.resize(count * batch.answers_per_item);
    const std::size_t item_bytes = items_.size() * sizeof(float);
    const std::size_t answer_bytes = answers_.size() * sizeof(std::uint32_t);
    if (item_bytes > capacity_) {
      item_buffer_ = cl::Buffer(program.context, CL_MEM_READ_ONLY, item_bytes);
      answer_buffer_ = cl::Buffer(program.context, CL_MEM_WRITE_ONLY, answer_bytes);
      capacity_ = item_bytes;
    }
    const cl::Kernel kernel = batch.kernel(item_buffer_, count, answer_buffer_);
    const cl::CommandQueue& queue = program.queue;
    queue.enqueueWriteBuffer(item_buffer_, CL_FALSE, 0, item_bytes, items_.data(), nullptr,
                             commands_.add());
    queue.enqueueNDRangeKernel(kernel, cl::NullRange, workItems(program, count), workGroup(program),
                               nullptr, commands_.add());
    queue.enqueueReadBuffer(answer_buffer_, CL_FALSE, 0, answer_bytes, answers_.data(), nullptr,
                            commands_.add());
    queue.flush();
    begin_ = begin;
    end_ = end;
  }

  void finish(const DeviceBatch& batch)
  {
    commands_.wait();
    batch.finish(begin_, end_, answers_);
    begin_ = end_;
  }

  std::size_t end() const { return end_; }

 private:
  std::vector<float> items_;
  std::vector<std::uint32_t> answers_;
  cl::Buffer item_buffer_, answer_buffer_;
  std::size_t capacity_ = 0, begin_ = 0, end_ = 0;
  DeviceCommands commands_;  // the last: ends before what it reads and writes
};

/// Runs a batch chunk by chunk, in order. While the device has one, the host finishes the one
/// before and packs the next. Throws cl::Error, Cancelled, or what `pack` and `finish` throw; items
/// finished by then stay so, and nothing runs on.
void runBatch(const OpenClProgram& program, const DeviceBatch& batch,
              const mesh_map::BvhOptions& run)
{
  const auto proceed = [&](std::size_t done) {
    if (run.cancel && *run.cancel) {
      throw mesh_map::Cancelled();
    }
    if (run.progress) {
      run.progress(static_cast<double>(done) / static_cast<double>(batch.count));
    }
  };
  const std::size_t size = chunkSize(program);
  std::array<Slot, SLOTS> slots;
  std::size_t chunk = 0;
  proceed(0);
  for (std::size_t begin = 0; begin < batch.count; begin += size, ++chunk) {
    Slot& next = slots[chunk % SLOTS];
    if (next.busy()) {
      next.finish(batch);
      proceed(next.end());
    }
    next.start(program, batch, begin, std::min(batch.count, begin + size));
  }
  for (std::size_t i = 0; i < SLOTS; ++i, ++chunk) {
    Slot& next = slots[chunk % SLOTS];
    if (next.busy()) {
      next.finish(batch);
      proceed(next.end());
    }
  }
}

std::size_t nodeBytes(const mesh_map::Bvh& bvh)
{
  return bvh.nodes().size() * sizeof(mesh_map::BvhNode);
}

std::size_t cornerCount(const mesh_map::Bvh& bvh)
{
  return bvh.corners().size() + mesh_map::Bvh::TAIL;
}

/// What a batch takes of the device per item: more than any kernel needs.
constexpr std::size_t BYTES_PER_ITEM = 128;

/// Packing and finishing are a small part of a batch: they have its threads and look at its cancel
/// flag, but their progress is not the batch's.
BvhOptions part(const BvhOptions& run)
{
  BvhOptions options;
  options.threads = run.threads;
  options.cancel = run.cancel;
  return options;
}

void setArguments(cl::Kernel&, cl_uint) {}

template <class T, class... Others>
void setArguments(cl::Kernel& kernel, cl_uint index, const T& value, const Others&... others)
{
  kernel.setArg(index, value);
  setArguments(kernel, index + 1, others...);
}

template <class... Arguments>
cl::Kernel makeKernel(const OpenClProgram& program, const char* name, const Arguments&... arguments)
{
  cl::Kernel kernel(program.program, name);
  setArguments(kernel, 0, arguments...);
  return kernel;
}

}  // namespace

std::string DeviceQueries::refusal(const OpenClProgram& program, const mesh_map::Bvh& bvh)
{
  const std::size_t nodes = nodeBytes(bvh), corners = cornerCount(bvh) * sizeof(float);
  const std::size_t needed =
      nodes + corners + 2 * bvh.faceCount() + batchMemory(program, BYTES_PER_ITEM);
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

template <class T>
cl::Buffer DeviceQueries::upload(const T* values, std::size_t count) const
{
  return cl::Buffer(program_->context, CL_MEM_READ_ONLY | CL_MEM_COPY_HOST_PTR, count * sizeof(T),
                    const_cast<T*>(values));
}

cl::Buffer DeviceQueries::maskBuffer(ArrayView<std::uint8_t> mask) const
{
  const std::uint8_t none = 1;
  if (mask.empty()) {
    return upload(&none, 1);
  }
  const std::vector<std::uint8_t> by_triangle = mesh_map::deviceMask(bvh_, mask);
  return upload(by_triangle.data(), by_triangle.size());
}

template <class Finish>
void DeviceQueries::runRays(const mesh_map::RayBatch& rays, const mesh_map::RayOptions& options,
                            cl_uint flags, const BvhOptions& run, const Finish& finish) const
{
  flags |= options.back_faces ? mesh_map::DEVICE_BACK_FACES : 0;
  flags |= options.mask.empty() ? 0 : mesh_map::DEVICE_MASKED;
  const cl::Buffer mask = maskBuffer(options.mask);
  DeviceBatch batch;
  batch.count = rays.size();
  batch.answers_per_item = mesh_map::DEVICE_RAY_ANSWERS;
  batch.pack = [&](std::size_t begin, std::size_t end) {
    return mesh_map::packRays(bvh_, slice(rays, begin, end), part(run));
  };
  batch.kernel = [&](const cl::Buffer& items, std::size_t count, const cl::Buffer& answers) {
    return makeKernel(*program_, "cast_rays", nodes_, corners_, items, mask, flags,
                      static_cast<cl_uint>(count), answers);
  };
  batch.finish = [&](std::size_t begin, std::size_t end, ArrayView<std::uint32_t> answers) {
    finish(slice(rays, begin, end), answers);
  };
  runBatch(*program_, batch, run);
}

void DeviceQueries::castRays(const mesh_map::RayBatch& rays, const mesh_map::RayOptions& options,
                             const BvhOptions& run, mesh_map::RayHits& hits) const
{
  runRays(rays, options, 0, run,
          [&](const mesh_map::RayBatch& chunk, ArrayView<std::uint32_t> answers) {
            append(hits, mesh_map::finishRays(bvh_, chunk, options, answers, part(run)));
          });
}

void DeviceQueries::raysHitAny(const mesh_map::RayBatch& rays, const mesh_map::RayOptions& options,
                               const BvhOptions& run, std::vector<std::uint8_t>& hits) const
{
  runRays(rays, options, mesh_map::DEVICE_ANY_HIT, run,
          [&](const mesh_map::RayBatch& chunk, ArrayView<std::uint32_t> answers) {
            append(hits, mesh_map::finishRaysAny(bvh_, chunk, options, answers, part(run)));
          });
}

void DeviceQueries::closestPoints(ArrayView<double> points, const mesh_map::ClosestOptions& options,
                                  const BvhOptions& run, mesh_map::SurfaceHits& hits) const
{
  const cl::Buffer mask = maskBuffer(options.mask);
  const cl_uint flags = options.mask.empty() ? 0 : mesh_map::DEVICE_MASKED;
  DeviceBatch batch;
  batch.count = points.size() / 3;
  batch.answers_per_item = mesh_map::DEVICE_CANDIDATES;
  batch.pack = [&](std::size_t begin, std::size_t end) {
    return mesh_map::packPoints(bvh_, slice(points, 3, begin, end), slice(options, begin, end),
                                part(run));
  };
  batch.kernel = [&](const cl::Buffer& items, std::size_t count, const cl::Buffer& answers) {
    return makeKernel(*program_, "closest_points", nodes_, corners_, items, mask, flags,
                      static_cast<cl_uint>(count), answers);
  };
  batch.finish = [&](std::size_t begin, std::size_t end, ArrayView<std::uint32_t> answers) {
    append(hits, mesh_map::finishPoints(bvh_, slice(points, 3, begin, end),
                                        slice(options, begin, end), answers, part(run)));
  };
  runBatch(*program_, batch, run);
}

std::vector<std::uint32_t> DeviceQueries::selectFaces(const mesh_map::Region& region,
                                                      const std::vector<std::uint32_t>& roots,
                                                      mesh_map::SelectionMode mode,
                                                      ArrayView<std::uint8_t> mask,
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
    const cl::Buffer region_buffer = upload(numbers.data(), numbers.size());
    const cl::Buffer root_buffer = upload(roots.data(), roots.size());
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
  return mesh_map::finishSelection(bvh_, region, mode, mask, verdicts, run);
}

}  // namespace rviz_mesh_plugin
