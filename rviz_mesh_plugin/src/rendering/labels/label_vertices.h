#pragma once

#include <cstddef>

#include <OgreHardwareVertexBuffer.h>
#include <OgreVertexIndexData.h>

#include "base/mesh_data.h"
#include "rendering/labels/label_object.h"

namespace rviz_mesh_plugin {

/// The vertex buffer that all labels of a mesh share: uploaded in slices, once.
class LabelVertices
{
 public:
  LabelVertices();
  LabelVertices(const LabelVertices&) = delete;
  LabelVertices& operator=(const LabelVertices&) = delete;

  void setMesh(const MeshDataConstPtr& mesh);

  /// Uploads at most @a limit bytes (but one vertex at least); returns how many.
  std::size_t upload(std::size_t limit);
  /// Forgets the mesh.
  void giveUp() { setMesh(nullptr); }

  std::size_t gpuBytes() const;
  const LabelledMesh& shared() const { return shared_; }

 private:
  Ogre::VertexData data_;
  Ogre::HardwareVertexBufferSharedPtr buffer_;
  LabelledMesh shared_;
};

}  // namespace rviz_mesh_plugin
