#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

namespace rviz_mesh_plugin {

/// A polygon in the plane.
class Outline
{
 public:
  /// @throw std::invalid_argument where it has no area, or crosses itself
  explicit Outline(std::vector<Eigen::Vector2d> corners);

  double area() const;
  bool contains(const Eigen::Vector2d& point) const;
  bool meets(const Eigen::Vector2d& a, const Eigen::Vector2d& b) const;

  /// Whether a box along the axes is not farther away than rounding may be.
  bool isNear(const Eigen::Vector2d& low, const Eigen::Vector2d& high) const;
  /// Whether one of its sides goes through a box.
  bool cuts(const Eigen::Vector2d& low, const Eigen::Vector2d& high) const;

  /// Of a face, what is within it in the first two coordinates: its area, and that in the plane.
  Eigen::Vector2d within(const std::vector<Eigen::Vector3d>& face) const;

 private:
  template <class Visit>
  void visitSides(const Visit& visit) const
  {
    for (std::size_t i = 0; i < corners_.size(); ++i) {
      visit(corners_[i], corners_[(i + 1) % corners_.size()]);
    }
  }
  void refuse() const;

  std::vector<Eigen::Vector2d> corners_;
  Eigen::Vector2d low_, high_;
  double area_ = 0.0;  ///< negative where it is clockwise
};

/// Twice the area of a polygon in space, and twice that in its first two coordinates.
Eigen::Vector2d twiceAreas(const std::vector<Eigen::Vector3d>& polygon);

}  // namespace rviz_mesh_plugin
