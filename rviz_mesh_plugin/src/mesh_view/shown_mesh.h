#pragma once

#include <string>

#include <OgreQuaternion.h>

#include "base/mesh_data.h"
#include "rendering/ogre_compatibility.h"
#include "sources/mesh_source.h"

namespace rviz_mesh_plugin {

/// A mesh as it lies in the fixed frame, and who shows it.
struct ShownMesh
{
  MeshDataConstPtr mesh;
  Ogre::Vector3 position = Ogre::Vector3::ZERO;
  Ogre::Quaternion orientation = Ogre::Quaternion::IDENTITY;
  std::string display;  ///< its name
  MeshSource source;    ///< of the display; its labels are in labelNamespace() of it
};

}  // namespace rviz_mesh_plugin
