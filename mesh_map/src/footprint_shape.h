#ifndef MESH_MAP_SRC_FOOTPRINT_SHAPE_H
#define MESH_MAP_SRC_FOOTPRINT_SHAPE_H

#include <mesh_map/footprint.h>
#include <mesh_map/region.h>

#include <array>
#include <cstddef>
#include <vector>

#include "vector3.h"

namespace mesh_map {

using Point2 = std::array<double, 2>;

/// Where a robot is: the rows of its matrix.
class RobotPose
{
 public:
  explicit RobotPose(const double* numbers);

  bool finite() const { return finite_; }

  /// A plane of the frame of the robot in that of the mesh.
  Plane plane(const Plane& robot) const;

  /// A point of the mesh in the frame of the robot.
  Vector3 local(const Vector3& point) const;

 private:
  std::array<Vector3, 3> rows_;
  Vector3 shift_;
  bool finite_ = true;
};

/// A footprint, ready to be asked.
class FootprintShape
{
 public:
  /// Throws std::invalid_argument for a polygon that is not convex and counter-clockwise.
  explicit FootprintShape(const Footprint& footprint);

  /// The band, cut into pieces of few enough planes for a ConvexRegion.
  const std::vector<std::vector<Plane>>& pieces() const { return pieces_; }

  /// Points of the polygon: the centers of the cells of a grid. In rows.
  std::size_t sampleCount() const { return sample_count_; }

  /// Marks the samples in a convex polygon, whichever way round it runs.
  void mark(const std::vector<Point2>& polygon, std::vector<std::uint8_t>& samples) const;

  /// Share of the samples that are marked.
  double share(const std::vector<std::uint8_t>& samples) const;

 private:
  void addPiece(const Footprint& footprint, std::size_t first, std::size_t last);
  void addSamples(const std::vector<Point2>& corners);

  struct Row
  {
    double y;
    double first_x;
    std::size_t begin, count;  // in the samples
  };
  std::vector<std::vector<Plane>> pieces_;
  std::vector<Row> rows_;
  std::size_t sample_count_ = 0;
  double step_ = 0.0;
};

}  // namespace mesh_map

#endif  // MESH_MAP_SRC_FOOTPRINT_SHAPE_H
