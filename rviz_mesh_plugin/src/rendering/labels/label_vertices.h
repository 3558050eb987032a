#pragma once

#include <cstddef>

#include <OgreAxisAlignedBox.h>
#include <OgreHardwareVertexBuffer.h>
#include <OgreVertexIndexData.h>

#include "base/mesh_data.h"

namespace rviz_mesh_plugin {

/// The vertex buffer that all labels of a mesh share: uploaded in slices, once.
class LabelVertices
{
 public:
  LabelVertices();
  LabelVertices(const LabelVertices&) = delete;
  LabelVertices& operator=(const LabelVertices&) = delete;

  void setMesh(const MeshDataConstPtr& mesh);
  const MeshDataConstPtr& mesh() const { return mesh_; }
  const Ogre::AxisAlignedBox& box() const { return box_; }
  /// Typical length of an edge, in meters.
  float edge() const { return edge_; }

  /// Uploads at most @a limit bytes (but one vertex at least); returns how many.
  std::size_t upload(std::size_t limit);
  bool complete() const { return mesh_ && uploaded_ == mesh_->vertexCount(); }

  std::size_t gpuBytes() const;
  Ogre::VertexData* data() { return &data_; }

 private:
  MeshDataConstPtr mesh_;
  Ogre::AxisAlignedBox box_;
  float edge_ = 0.0f;
  Ogre::VertexData data_;
  Ogre::HardwareVertexBufferSharedPtr buffer_;
  std::size_t uploaded_ = 0;  ///< vertices
};

}  // namespace rviz_mesh_plugin
