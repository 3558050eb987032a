#pragma once

#include <cstddef>

#include <OgreColourValue.h>
#include <OgrePrerequisites.h>

namespace rviz_mesh_plugin {

/// The part of a surface's color that is seen where no light falls.
constexpr float AMBIENT_SHARE = 0.4f;

/// What a lit surface has its color from.
struct SurfaceColor
{
  enum class From
  {
    ONE,         ///< one color everywhere
    VERTICES,    ///< the vertex buffer
    RENDERABLES  ///< a custom parameter of each renderable
  };

  From from = From::ONE;
  Ogre::ColourValue color;           ///< ONE
  std::size_t custom_parameter = 0;  ///< RENDERABLES
  float alpha = 1.0f;                ///< multiplies that of vertices, renderables and the texture
  bool textured = false;             ///< the first texture of the pass replaces the color
  bool flat_shading = false;         ///< lit by the planes of the faces
};

/// Makes a pass light faces from whichever side they are seen, by RViz's light (directional, along
/// the view): a surface that faces the camera has exactly its color, and AMBIENT_SHARE of it where
/// the light grazes.
///
/// The pass gets a pair of GLSL 1.20 programs, which all passes of this process share, and no
/// culling.
void setTwoSidedLighting(Ogre::Pass* pass, const SurfaceColor& surface);

}  // namespace rviz_mesh_plugin
