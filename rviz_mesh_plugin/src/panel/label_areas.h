#pragma once

#include <chrono>
#include <cstddef>
#include <map>
#include <optional>
#include <string>

#include "base/mesh_data.h"

namespace rviz_mesh_plugin {

/// The areas of the faces of labels, found in slices.
class LabelAreas
{
 public:
  /// Works for about this long; true where all are known.
  bool work(const MeshDataConstPtr& mesh, const LabelClusters& labels,
            std::chrono::microseconds budget);

  /// In square meters of the mesh; nothing while it is not known.
  std::optional<double> area(const std::string& label) const;

 private:
  struct Sum
  {
    LabelClusterConstPtr label;
    std::size_t next = 0;  ///< of its faces
    double area = 0.0;
  };
  MeshDataConstPtr mesh_;
  std::map<std::string, Sum> sums_;
};

}  // namespace rviz_mesh_plugin
