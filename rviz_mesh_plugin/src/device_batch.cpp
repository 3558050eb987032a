#include "device_batch.h"

#include <mesh_map/bvh_device.h>

#include <algorithm>
#include <array>

namespace rviz_mesh_plugin {

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

}  // namespace

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

cl::NDRange workGroup(const OpenClProgram& program)
{
  return cl::NDRange(groupSize(program));
}

cl::NDRange workItems(const OpenClProgram& program, std::size_t count)
{
  const std::size_t group = groupSize(program);
  return cl::NDRange((count + group - 1) / group * group);
}

std::size_t batchMemory(const OpenClProgram& program, std::size_t bytes_per_item)
{
  return SLOTS * chunkSize(program) * bytes_per_item;
}

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

}  // namespace rviz_mesh_plugin
