#pragma once

#define CL_TARGET_OPENCL_VERSION 120
#define CL_HPP_TARGET_OPENCL_VERSION 120
#define CL_HPP_MINIMUM_OPENCL_VERSION 120
#define CL_HPP_ENABLE_EXCEPTIONS
#if __has_include(<CL/opencl.hpp>)
#include <CL/opencl.hpp>
#else
#include <CL/cl2.hpp>
#endif

#include <mesh_map/bvh/device/bvh_device.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

/// The first OpenCL device, with the kernels built for it.
class TestDevice
{
 public:
  /// Null where there is none.
  static std::shared_ptr<const TestDevice> get()
  {
    static const std::shared_ptr<const TestDevice> device = make();
    return device;
  }

  explicit TestDevice(const cl::Device& device, const std::string& more_options = "")
      : device_(device),
        context_(device),
        queue_(context_, device),
        program_(context_, std::string(mesh_map::BVH_KERNELS))
  {
    program_.build({device}, (mesh_map::BVH_KERNEL_OPTIONS + more_options).c_str());
  }

  /// The same device, as one on which numbers below 2^-126 are 0, if it can be that.
  std::shared_ptr<const TestDevice> withoutDenormals() const
  {
    return std::make_shared<const TestDevice>(device_, " -cl-denorms-are-zero");
  }

  template <class T>
  cl::Buffer upload(const T* values, std::size_t count) const
  {
    return cl::Buffer(context_, CL_MEM_READ_WRITE | CL_MEM_COPY_HOST_PTR, count * sizeof(T),
                      const_cast<T*>(values));
  }
  template <class T>
  cl::Buffer upload(const std::vector<T>& values) const
  {
    return upload(values.data(), values.size());
  }

  /// Runs a kernel for `items` work items. The result, of which there is a first version, is its
  /// last argument.
  template <class T, class... Arguments>
  void run(const char* name, std::size_t items, std::vector<T>& result,
           const Arguments&... arguments) const
  {
    constexpr std::size_t group = mesh_map::DEVICE_WORK_GROUP;
    const cl::Buffer buffer = upload(result);
    cl::Kernel kernel(program_, name);
    setArguments(kernel, 0, arguments..., buffer);
    queue_.enqueueNDRangeKernel(kernel, cl::NullRange,
                                cl::NDRange((items + group - 1) / group * group),
                                cl::NDRange(group));
    queue_.enqueueReadBuffer(buffer, CL_TRUE, 0, result.size() * sizeof(T), result.data());
  }

 private:
  static std::shared_ptr<const TestDevice> make()
  {
    std::vector<cl::Platform> platforms;
    try {
      cl::Platform::get(&platforms);
    } catch (const cl::Error&) {
      return nullptr;  // that there are none is an error
    }
    for (const cl::Platform& platform : platforms) {
      std::vector<cl::Device> devices;
      platform.getDevices(CL_DEVICE_TYPE_ALL, &devices);
      if (!devices.empty()) {
        return std::make_shared<const TestDevice>(devices.front());
      }
    }
    return nullptr;
  }

  static void setArguments(cl::Kernel&, cl_uint) {}
  template <class T, class... Others>
  static void setArguments(cl::Kernel& kernel, cl_uint index, const T& value,
                           const Others&... others)
  {
    kernel.setArg(index, value);
    setArguments(kernel, index + 1, others...);
  }

  cl::Device device_;
  cl::Context context_;
  cl::CommandQueue queue_;
  cl::Program program_;
};

/// A mesh on the device.
class DeviceMesh
{
 public:
  DeviceMesh(std::shared_ptr<const TestDevice> device, const mesh_map::Bvh& bvh)
      : device_(std::move(device)),
        bvh_(bvh),
        nodes_(device_->upload(bvh.nodes().data(), bvh.nodes().size())),
        corners_(device_->upload(bvh.corners().data(), bvh.corners().size() + mesh_map::Bvh::TAIL))
  {
  }

  std::vector<std::uint32_t> castRays(const mesh_map::RayBatch& rays,
                                      const mesh_map::RayOptions& options, bool any = false) const
  {
    std::vector<std::uint32_t> answers(rays.size() * mesh_map::DEVICE_RAY_ANSWERS, 7);
    const cl_uint flags = (options.back_faces ? mesh_map::DEVICE_BACK_FACES : 0) |
                          (any ? mesh_map::DEVICE_ANY_HIT : 0) | maskFlag(options.mask);
    device_->run("cast_rays", rays.size(), answers, nodes_, corners_,
                 device_->upload(mesh_map::packRays(bvh_, rays)), mask(options.mask), flags,
                 static_cast<cl_uint>(rays.size()));
    return answers;
  }

  std::vector<std::uint32_t> closestPoints(mesh_map::ArrayView<double> points,
                                           const mesh_map::ClosestOptions& options) const
  {
    const std::size_t count = points.size() / 3;
    std::vector<std::uint32_t> answers(count * mesh_map::DEVICE_CANDIDATES, 7);
    device_->run("closest_points", count, answers, nodes_, corners_,
                 device_->upload(mesh_map::packPoints(bvh_, points, options)), mask(options.mask),
                 maskFlag(options.mask), static_cast<cl_uint>(count));
    return answers;
  }

  std::vector<std::uint8_t> select(const mesh_map::Region& region) const
  {
    std::vector<std::uint8_t> verdicts(bvh_.faceCount(), mesh_map::DEVICE_OUTSIDE);
    const std::vector<std::uint32_t> roots = mesh_map::selectionRoots(bvh_, region);
    if (roots.empty()) {
      return verdicts;
    }
    const auto count = static_cast<cl_uint>(roots.size() / 2);
    if (const auto* sphere = dynamic_cast<const mesh_map::SphereRegion*>(&region)) {
      device_->run("select_sphere", count, verdicts, nodes_, corners_,
                   device_->upload(mesh_map::packSphere(bvh_, *sphere)), device_->upload(roots),
                   count);
    } else {
      const auto& convex = dynamic_cast<const mesh_map::ConvexRegion&>(region);
      device_->run("select_planes", count, verdicts, nodes_, corners_,
                   device_->upload(mesh_map::packPlanes(bvh_, convex)),
                   static_cast<cl_uint>(convex.planes().size()), device_->upload(roots), count);
    }
    return verdicts;
  }

 private:
  cl::Buffer mask(mesh_map::ArrayView<std::uint8_t> mask) const
  {
    return device_->upload(mask.empty() ? std::vector<std::uint8_t>{1}
                                        : mesh_map::deviceMask(bvh_, mask));
  }
  static cl_uint maskFlag(mesh_map::ArrayView<std::uint8_t> mask)
  {
    return mask.empty() ? 0 : mesh_map::DEVICE_MASKED;
  }

  std::shared_ptr<const TestDevice> device_;
  const mesh_map::Bvh& bvh_;
  cl::Buffer nodes_, corners_;
};
