#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "base/mesh_data.h"

namespace rviz_mesh_plugin {

/// Which labels have to be drawn over which: those that have faces in common. Found in slices.
class LabelLayers
{
 public:
  /// OGRE is slow with many layers: of more labels on one face, it is open which one is seen.
  static constexpr unsigned short COUNT = 16;

  using Labels = std::vector<LabelClusterConstPtr>;
  /// Is told the layer of a label, 0 at the bottom.
  using Place = std::function<void(const LabelCluster& label, unsigned short layer)>;

  /// Begins anew.
  /// @param labels from the bottom to the top, all on a mesh of so many faces: those that share
  /// faces get ascending layers
  void start(std::size_t face_count, Labels labels);

  /// Looks at about so many faces; returns at how many, 0 where all labels have been placed.
  std::size_t work(std::size_t limit, const Place& place);
  bool isDone() const { return labels_.empty(); }

 private:
  std::size_t look(const LabelCluster& label, std::size_t limit);

  Labels labels_;
  std::size_t label_ = 0;            ///< that is being looked at
  std::vector<std::uint8_t> above_;  ///< the first free layer over each face
  bool found_ = false;               ///< the layer of the label
  std::size_t next_ = 0;             ///< of its faces, to find its layer or to be covered
  unsigned short layer_ = 0;         ///< of the label
};

}  // namespace rviz_mesh_plugin
