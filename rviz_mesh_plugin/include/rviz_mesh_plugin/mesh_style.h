#pragma once

#include <OgreColourValue.h>

namespace rviz_mesh_plugin {

/// How a MeshVisual looks: everything but its data. Alpha is in the colors.
struct MeshStyle
{
  enum class Faces
  {
    HIDDEN,
    FIXED_COLOR,
    VERTEX_COLORS  ///< those of MeshVisual::setColors(); faces_color where there are none
  };

  Faces faces = Faces::FIXED_COLOR;
  Ogre::ColourValue faces_color{0.0f, 1.0f, 0.0f, 1.0f};
  bool show_wireframe = false;
  Ogre::ColourValue wireframe_color{0.0f, 0.0f, 0.0f, 1.0f};
  bool show_normals = false;
  Ogre::ColourValue normals_color{1.0f, 0.0f, 1.0f, 1.0f};
  float normals_length = 0.1f;  ///< in meters
};

}  // namespace rviz_mesh_plugin
