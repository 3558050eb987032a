#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace rviz_mesh_plugin {

/// Which labels have to be drawn over which: those that have faces in common. As long as none has,
/// that costs nothing but a byte per face.
class LabelLayers
{
 public:
  using Faces = std::vector<std::uint32_t>;

  /// OGRE is slow with many layers: of more labels on one face, it is open which one is seen.
  static constexpr unsigned short COUNT = 16;

  /// Forgets all labels.
  void reset(std::size_t face_count);
  void add(const Faces& faces);
  void remove(const Faces& faces);

  /// Whether a face has two labels.
  bool overlap() const { return overlapping_ > 0; }

  /// The layer of each label, 0 at the bottom: labels that share faces have ascending ones.
  std::vector<unsigned short> layers(const std::vector<const Faces*>& labels) const;

 private:
  std::vector<std::uint8_t> counts_;  ///< labels of each face; 255 and more are not counted down
  std::size_t overlapping_ = 0;       ///< faces with several labels
};

}  // namespace rviz_mesh_plugin
