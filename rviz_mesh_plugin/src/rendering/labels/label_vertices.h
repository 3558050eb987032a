#pragma once

#include <cstddef>

#include <OgreAxisAlignedBox.h>
#include <OgreHardwareVertexBuffer.h>
#include <OgreVertexIndexData.h>

#include "base/mesh_data.h"
#include "threads/work_thread.h"

namespace rviz_mesh_plugin {

/// The vertex buffer that all labels of a mesh share, uploaded in slices, once, and the thread on
/// which what they are drawn by is made, one after the other.
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
  WorkThread& thread() { return thread_; }

 private:
  MeshDataConstPtr mesh_;
  Ogre::AxisAlignedBox box_;
  float edge_ = 0.0f;
  Ogre::VertexData data_;
  Ogre::HardwareVertexBufferSharedPtr buffer_;
  std::size_t uploaded_ = 0;  ///< vertices
  WorkThread thread_{"labels"};
};

}  // namespace rviz_mesh_plugin
