#include "mesh/repair/hole_loops.h"

#include <mesh_map/base/parallel.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "mesh/repair/box_grid.h"

namespace mesh_map {
namespace {

/// The eigenvector of the smallest eigenvalue of a symmetric matrix, by Jacobi's rotations.
Vector3 smallestAxis(std::array<Vector3, 3> matrix)
{
  std::array<Vector3, 3> axes = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};  // columns
  for (int sweep = 0; sweep < 20; ++sweep) {
    for (std::size_t p = 0; p < 2; ++p) {
      for (std::size_t q = p + 1; q < 3; ++q) {
        if (matrix[p][q] == 0.0) {
          continue;
        }
        const double theta = 0.5 * std::atan2(2.0 * matrix[p][q], matrix[q][q] - matrix[p][p]);
        const double c = std::cos(theta), s = std::sin(theta);
        for (std::size_t k = 0; k < 3; ++k) {
          const double kp = matrix[k][p], kq = matrix[k][q];
          matrix[k][p] = c * kp - s * kq;
          matrix[k][q] = s * kp + c * kq;
        }
        for (std::size_t k = 0; k < 3; ++k) {
          const double pk = matrix[p][k], qk = matrix[q][k];
          matrix[p][k] = c * pk - s * qk;
          matrix[q][k] = s * pk + c * qk;
          const double ap = axes[k][p], aq = axes[k][q];
          axes[k][p] = c * ap - s * aq;
          axes[k][q] = s * ap + c * aq;
        }
      }
    }
  }
  std::size_t least = 0;
  for (std::size_t k = 1; k < 3; ++k) {
    least = matrix[k][k] < matrix[least][least] ? k : least;
  }
  return {axes[0][least], axes[1][least], axes[2][least]};
}

class LoopJudge
{
 public:
  LoopJudge(const MeshView& mesh, const Topology& topology, const BorderLoops& loops,
            const HoleLimits& limits)
      : mesh_(mesh), topology_(topology), loops_(loops), limits_(limits)
  {
  }

  LoopShapes judgeAll(unsigned threads)
  {
    result_.fates.assign(loops_.size(), static_cast<std::uint8_t>(HoleFate::FILLED));
    result_.perimeters.assign(loops_.size(), 0.0);
    result_.deviations.assign(loops_.size(), 0.0);
    result_.normals.resize(loops_.size());
    parallelEach(loops_.size(), 64, threads,
                 [this](std::size_t loop) { judge(static_cast<std::uint32_t>(loop)); });
    if (limits_.keep_outer) {
      markOuter();
    }
    return std::move(result_);
  }

 private:
  Vector3 pointAt(std::uint32_t vertex) const { return pointOf(mesh_.vertex(vertex)); }

  void setFate(std::uint32_t loop, HoleFate fate)
  {
    result_.fates[loop] = static_cast<std::uint8_t>(fate);
  }

  void judge(std::uint32_t loop)
  {
    const std::uint32_t* const vertices = loops_.vertices.data();
    const std::uint32_t begin = loops_.offsets[loop], end = loops_.offsets[loop + 1];
    double perimeter = 0.0;
    Vector3 middle = {0.0, 0.0, 0.0};
    for (std::uint32_t i = begin; i < end; ++i) {
      const Vector3 a = pointAt(vertices[i]), b = pointAt(vertices[i + 1 < end ? i + 1 : begin]);
      const double length = distance(a, b);
      perimeter += length;
      middle = middle + 0.5 * length * (a + b);
    }
    middle = perimeter > 0.0 ? middle / perimeter : pointAt(vertices[begin]);
    std::array<Vector3, 3> spread = {};
    for (std::uint32_t i = begin; i < end; ++i) {
      const Vector3 a = pointAt(vertices[i]) - middle;
      const double weight =
          distance(pointAt(vertices[i]), pointAt(vertices[i + 1 < end ? i + 1 : begin])) +
          distance(pointAt(vertices[i]), pointAt(vertices[i > begin ? i - 1 : end - 1]));
      for (std::size_t p = 0; p < 3; ++p) {
        spread[p] = spread[p] + weight * a[p] * a;
      }
    }
    const Vector3 normal = smallestAxis(spread);
    double deviation = 0.0;
    for (std::uint32_t i = begin; i < end; ++i) {
      deviation = std::max(deviation, std::abs(dot(pointAt(vertices[i]) - middle, normal)));
    }
    result_.perimeters[loop] = perimeter;
    result_.deviations[loop] = deviation;
    result_.normals[loop] = normal;
    const double slope = std::acos(std::min(1.0, std::abs(dot(normal, limits_.up))));
    if (!(perimeter < limits_.perimeter)) {
      setFate(loop, HoleFate::LONG);
    } else if (!(deviation <= limits_.flatness * perimeter)) {
      setFate(loop, HoleFate::UNEVEN);
    } else if (slope > limits_.slope) {
      setFate(loop, HoleFate::STEEP);
    }
  }

  void markOuter()
  {
    std::vector<std::uint32_t> longest(topology_.component_count, NO_INDEX);
    for (std::uint32_t loop = 0; loop < loops_.size(); ++loop) {
      std::uint32_t& best = longest[componentOf(loop)];
      if (best == NO_INDEX || result_.perimeters[loop] > result_.perimeters[best]) {
        best = loop;
      }
    }
    std::vector<Box> boxes(topology_.component_count);
    for (std::uint32_t v = 0; v < mesh_.vertexCount(); ++v) {
      boxes[std::size_t(topology_.components[v])].add(pointAt(v));
    }
    for (std::size_t component = 0; component < longest.size(); ++component) {
      const std::uint32_t loop = longest[component];
      if (loop != NO_INDEX) {
        Box box;
        for (std::uint32_t i = loops_.offsets[loop]; i < loops_.offsets[loop + 1]; ++i) {
          box.add(pointAt(loops_.vertices[i]));
        }
        if (box.diagonal() >= 0.5 * boxes[component].diagonal()) {
          setFate(loop, HoleFate::OUTER);
        }
      }
    }
  }

  std::size_t componentOf(std::uint32_t loop) const
  {
    return std::size_t(topology_.components[loops_.vertices[loops_.offsets[loop]]]);
  }

  MeshView mesh_;
  const Topology& topology_;
  const BorderLoops& loops_;
  HoleLimits limits_;
  LoopShapes result_;
};

}  // namespace

LoopShapes loopShapes(const MeshView& mesh, const Topology& topology, const BorderLoops& loops,
                      const HoleLimits& limits, unsigned threads)
{
  return LoopJudge(mesh, topology, loops, limits).judgeAll(threads);
}

}  // namespace mesh_map
