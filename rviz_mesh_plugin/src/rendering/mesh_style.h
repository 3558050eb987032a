#pragma once

#include <cstddef>
#include <tuple>

#include <OgreColourValue.h>

#include "base/section.h"

namespace rviz_mesh_plugin {

/// How a MeshVisual looks: everything but its data. Alpha is in the colors.
struct MeshStyle
{
  enum class Faces
  {
    HIDDEN,
    FIXED_COLOR,
    VERTEX_COLORS,  ///< those of MeshVisual::setColors(); faces_color where there are none
    TEXTURES        ///< materials of the layout; faces_color where it has none
  };

  /// Which faces are left out, seen from the camera.
  enum class Culling
  {
    NONE,
    BACK,  ///< those wound clockwise
    FRONT  ///< those wound anticlockwise
  };

  Faces faces = Faces::FIXED_COLOR;
  Ogre::ColourValue faces_color{0.0f, 1.0f, 0.0f, 1.0f};
  float alpha = 1.0f;          ///< of vertex colors and textures, multiplies theirs
  bool only_textured = false;  ///< TEXTURES: faces without a texture are left out
  bool flat_shading = false;   ///< light each face by its plane, not by the normals of its vertices
  Culling culling = Culling::NONE;
  bool level_of_detail = true;
  float detail_pixels = 4.0f;     ///< faces smaller than this may be merged
  float contour_interval = 0.0f;  ///< meters between lines of the same height; 0 is none
  Section section;                ///< what is drawn, in the coordinates of the mesh
  bool show_wireframe = false;
  Ogre::ColourValue wireframe_color{0.0f, 0.0f, 0.0f, 1.0f};
  bool show_normals = false;
  Ogre::ColourValue normals_color{1.0f, 0.0f, 1.0f, 1.0f};
  float normals_length = 0.1f;  ///< in meters
};

inline bool operator==(const MeshStyle& a, const MeshStyle& b)
{
  const auto members = [](const MeshStyle& style) {
    return std::tie(style.faces, style.faces_color, style.alpha, style.only_textured,
                    style.flat_shading, style.culling, style.level_of_detail, style.detail_pixels,
                    style.contour_interval, style.section.lower, style.section.upper,
                    style.show_wireframe, style.wireframe_color, style.show_normals,
                    style.normals_color, style.normals_length);
  };
  return members(a) == members(b);
}

inline bool operator!=(const MeshStyle& a, const MeshStyle& b)
{
  return !(a == b);
}

/// More lines than this are neither told apart nor drawn without delay by software.
constexpr std::size_t MAX_NORMALS = 100000;

/// Normals are drawn for one vertex in this many.
constexpr std::size_t normalStride(std::size_t vertex_count)
{
  return vertex_count <= MAX_NORMALS ? 1 : (vertex_count + MAX_NORMALS - 1) / MAX_NORMALS;
}

}  // namespace rviz_mesh_plugin
