// Selection without an index: an OpenCL kernel looks at every triangle for each question, as the
// paper's tool does. All results are read back, gathered, and made the indices of a highlight.
#pragma once

#include "spatial/opencl.h"

#include <array>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "world.h"

namespace rviz_benchmark {

class LinearScan
{
 public:
  using Planes = std::array<std::array<float, 4>, 4>;

  /// @throw cl::Error, std::runtime_error where there is no device
  explicit LinearScan(const World& world) : world_(world), results_(world.faces.size())
  {
    std::vector<cl::Platform> platforms;
    cl::Platform::get(&platforms);
    std::vector<cl::Device> devices;
    for (const cl::Platform& platform : platforms) {
      platform.getDevices(CL_DEVICE_TYPE_ALL, &devices);
      if (!devices.empty()) {
        break;
      }
    }
    if (devices.empty()) {
      throw std::runtime_error("there is no OpenCL device");
    }
    context_ = cl::Context(devices.front());
    queue_ = cl::CommandQueue(context_, devices.front());
    cl::Program program(context_, std::string(SOURCE));
    program.build("");
    ray_ = cl::Kernel(program, "ray");
    sphere_ = cl::Kernel(program, "sphere");
    box_ = cl::Kernel(program, "box");
    std::vector<float> corners;
    corners.reserve(9 * world.faces.size());
    for (const auto& face : world.faces) {
      for (const std::uint32_t vertex : face) {
        corners.insert(corners.end(), world.vertices[vertex].begin(), world.vertices[vertex].end());
      }
    }
    corners_ = cl::Buffer(context_, corners.begin(), corners.end(), true);
    output_ = cl::Buffer(context_, CL_MEM_WRITE_ONLY, sizeof(float) * results_.size());
  }

  /// The number of selected faces, 0 or 1.
  std::size_t single(const std::array<double, 3>& origin, const std::array<double, 3>& direction)
  {
    ask(ray_, {point(origin), point(direction)});
    std::uint32_t nearest = 0;
    float distance = std::numeric_limits<float>::infinity();
    for (std::size_t i = 0; i < results_.size(); ++i) {
      if (results_[i] >= 0.0f && results_[i] < distance) {
        distance = results_[i];
        nearest = static_cast<std::uint32_t>(i);
      }
    }
    selected_.assign(distance < std::numeric_limits<float>::infinity() ? 1 : 0, nearest);
    distance_ = distance;
    return highlight();
  }

  /// Around where the ray meets the mesh.
  std::size_t radius(const std::array<double, 3>& origin, const std::array<double, 3>& direction,
                     float meters)
  {
    if (single(origin, direction) == 0) {
      return 0;
    }
    cl_float4 center = point(origin);
    for (int k = 0; k < 3; ++k) {
      center.s[k] += distance_ * static_cast<float>(direction[k]);
    }
    center.s[3] = meters;
    ask(sphere_, {center});
    return gather();
  }

  std::size_t box(const Planes& planes)
  {
    std::vector<cl_float4> arguments;
    for (const auto& plane : planes) {
      arguments.push_back({{plane[0], plane[1], plane[2], plane[3]}});
    }
    ask(box_, arguments);
    return gather();
  }

 private:
  static cl_float4 point(const std::array<double, 3>& p)
  {
    return {{static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2]), 0.0f}};
  }

  void ask(cl::Kernel& kernel, const std::vector<cl_float4>& arguments)
  {
    kernel.setArg(0, corners_);
    kernel.setArg(1, output_);
    for (std::size_t i = 0; i < arguments.size(); ++i) {
      kernel.setArg(static_cast<cl_uint>(2 + i), arguments[i]);
    }
    queue_.enqueueNDRangeKernel(kernel, cl::NullRange, cl::NDRange(results_.size()));
    queue_.enqueueReadBuffer(output_, CL_TRUE, 0, sizeof(float) * results_.size(), results_.data());
  }

  std::size_t gather()
  {
    selected_.clear();
    for (std::size_t i = 0; i < results_.size(); ++i) {
      if (results_[i] > 0.0f) {
        selected_.push_back(static_cast<std::uint32_t>(i));
      }
    }
    return highlight();
  }

  std::size_t highlight()
  {
    indices_.clear();
    for (const std::uint32_t face : selected_) {
      indices_.insert(indices_.end(), world_.faces[face].begin(), world_.faces[face].end());
    }
    return selected_.size();
  }

  static constexpr const char* SOURCE = R"(
float3 corner(__global const float* corners, int k)
{
  return vload3(3 * get_global_id(0) + k, corners);
}

__kernel void ray(__global const float* corners, __global float* result, float4 origin,
                  float4 direction)
{
  const float3 a = corner(corners, 0);
  const float3 u = corner(corners, 1) - a, v = corner(corners, 2) - a;
  const float3 p = cross(direction.xyz, v);
  const float determinant = dot(u, p);
  float distance = -1.0f;
  if (determinant != 0.0f) {
    const float3 t = origin.xyz - a;
    const float3 q = cross(t, u);
    const float x = dot(t, p) / determinant, y = dot(direction.xyz, q) / determinant;
    if (x >= 0.0f && y >= 0.0f && x + y <= 1.0f) {
      distance = dot(v, q) / determinant;
    }
  }
  result[get_global_id(0)] = distance;
}

__kernel void sphere(__global const float* corners, __global float* result, float4 ball)
{
  bool inside = false;
  for (int k = 0; k < 3; ++k) {
    inside = inside || distance(corner(corners, k), ball.xyz) <= ball.w;
  }
  result[get_global_id(0)] = inside ? 1.0f : -1.0f;
}

bool in_all(float3 p, float4 a, float4 b, float4 c, float4 d)
{
  return dot(p, a.xyz) + a.w >= 0.0f && dot(p, b.xyz) + b.w >= 0.0f &&
         dot(p, c.xyz) + c.w >= 0.0f && dot(p, d.xyz) + d.w >= 0.0f;
}

__kernel void box(__global const float* corners, __global float* result, float4 a, float4 b,
                  float4 c, float4 d)
{
  bool inside = false;
  for (int k = 0; k < 3; ++k) {
    inside = inside || in_all(corner(corners, k), a, b, c, d);
  }
  result[get_global_id(0)] = inside ? 1.0f : -1.0f;
}
)";

  const World& world_;
  cl::Context context_;
  cl::CommandQueue queue_;
  cl::Kernel ray_, sphere_, box_;
  cl::Buffer corners_, output_;
  std::vector<float> results_;
  std::vector<std::uint32_t> selected_, indices_;
  float distance_ = 0.0f;
};

}  // namespace rviz_benchmark
