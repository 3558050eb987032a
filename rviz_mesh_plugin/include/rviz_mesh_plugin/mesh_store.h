#pragma once

#include <cstddef>
#include <list>
#include <string>
#include <vector>

#include "rviz_mesh_plugin/mesh_data.h"

namespace rviz_mesh_plugin {

/// The mesh that is shown and the attributes of this and of other meshes, by uuid: costs and colors
/// that arrive before their geometry wait here for it.
class MeshStore
{
 public:
  /// Attributes are kept for this many meshes, those that got one last; and of each this many cost
  /// layers.
  static constexpr std::size_t MAX_MESHES = 8;
  static constexpr std::size_t MAX_LAYERS = 256;

  void setGeometry(const MeshDataConstPtr& mesh) { geometry_ = mesh; }
  void addCosts(const CostLayerConstPtr& layer);
  void addColors(const ColorLayerConstPtr& layer);
  void clearCosts();
  void clearColors();
  void clear();

  const MeshDataConstPtr& geometry() const { return geometry_; }

  /// Types of the cost layers of the mesh shown, in order of their first arrival.
  std::vector<std::string> costTypes() const;
  /// Cost layer or colors of the mesh shown, null where there are none.
  CostLayerConstPtr costs(const std::string& type) const;
  ColorLayerConstPtr colors() const;

  /// How many cost layers, and colors, wait for another geometry than the one shown.
  std::size_t waitingCosts() const;
  std::size_t waitingColors() const;

 private:
  struct Attributes
  {
    std::string uuid;
    std::vector<CostLayerConstPtr> costs;
    ColorLayerConstPtr colors;
  };

  Attributes& attributesOf(const std::string& uuid);
  const Attributes* shown() const;

  MeshDataConstPtr geometry_;
  std::list<Attributes> attributes_;  ///< the last changed first
};

}  // namespace rviz_mesh_plugin
