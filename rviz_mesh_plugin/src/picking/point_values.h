#pragma once

#include <array>
#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "base/layer_info.h"
#include "base/mesh_data.h"

namespace rviz_mesh_plugin {

/// The value of a layer at a point.
struct PointValue
{
  enum Kind
  {
    FINITE,
    LETHAL,
    UNKNOWN,
    NOT_LOADED
  };
  Kind kind = NOT_LOADED;
  double value = 0.0;  ///< FINITE
};

/// A layer at a point of a face: the mean of the corners, by their weights (paper, equation 1); or
/// the value of the face, for a layer of faces. Where a corner of weight counts as lethal or
/// unknown, so does the point; lethal outweighs unknown.
/// @param layer null, or of another size than the mesh: it has not arrived
/// @param face of the mesh
/// @param weights of its corners, the sum being 1
PointValue valueAt(const CostLayer* layer, const MeshData& mesh, std::uint32_t face,
                   const std::array<double, 3>& weights);

/// Whether the point is lethal by what the values of a layer mean: as above, where one of the
/// corners is.
bool isLethalAt(const CostLayer* layer, const LayerInfo& info, const MeshData& mesh,
                std::uint32_t face, const std::array<double, 3>& weights);

/// The corner of a face that is nearest to a point of it.
std::uint32_t nearestCorner(const MeshData& mesh, std::uint32_t face,
                            const std::array<double, 3>& point);

/// Adds the labels that a face has.
void addLabelsAt(const LabelClusters& labels, std::uint32_t face, std::set<std::string>& found);

/// What is known of a point of a mesh.
struct PointReport
{
  struct Position
  {
    std::string frame;
    std::array<double, 3> point{};
  };
  struct Layer
  {
    std::string name;
    PointValue value;
    LayerInfo info;
    bool lethal = false;
  };

  std::uint32_t face = 0;
  std::uint32_t vertex = 0;  ///< the nearest
  Position in_mesh;
  Position in_fixed_frame;
  std::set<std::string> labels;
  std::vector<Layer> layers;
};

/// In one line; the layers that close the point come before the values of all.
std::string textOf(const PointReport& report);

}  // namespace rviz_mesh_plugin
