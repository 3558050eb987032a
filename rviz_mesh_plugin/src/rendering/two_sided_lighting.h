#pragma once

#include <cstddef>

#include <OgreColourValue.h>
#include <OgreTexture.h>

#include "base/section.h"

namespace rviz_mesh_plugin {

/// The part of a surface's color that is seen where no light falls.
constexpr float AMBIENT_SHARE = 0.4f;

/// The part of a color that is seen of what looks down; of what is upright, the mean of it and 1.
constexpr float UNDERSIDE_SHARE = 0.6f;

/// Of the custom parameter of renderables that holds the color of a part.
constexpr std::size_t PART_COLOR = 17;

/// What a lit surface looks like.
struct SurfaceLook
{
  enum class Color
  {
    HIDDEN,
    ONE,       ///< color, everywhere
    VERTICES,  ///< of the vertex buffer
    PARTS,     ///< each renderable has its own, PART_COLOR
    TEXTURE    ///< texture
  };

  Color from = Color::ONE;
  Ogre::ColourValue color;
  float alpha = 1.0f;         ///< multiplies that of vertices, parts and the texture
  bool overlay = false;       ///< ONE, no flat shading, no contour lines: by less per face
  bool flat_shading = false;  ///< lit by the planes of the faces
  bool translucent = false;
  bool one_color_per_face = false;  ///< VERTICES: that of the last vertex
  float contour_interval = 0.0f;    ///< dark lines at heights (z) so many meters apart; 0 is none
  Ogre::TexturePtr texture;
  Section section;  ///< what is drawn, in the coordinates of the mesh
};

/// Makes a pass light faces from whichever side they are seen, by RViz's light (directional, along
/// the view): a surface that faces the camera has exactly its color, and AMBIENT_SHARE of it where
/// the light grazes. Beside it there is light from above, so that floors differ from walls: level
/// ground keeps its color, what looks down has UNDERSIDE_SHARE of it.
///
/// The pass gets a pair of GLSL 1.20 programs, which passes of this process share, and no
/// culling.
void setTwoSidedLighting(Ogre::Pass* pass, const SurfaceLook& look);

/// Makes a pass draw what lies in a section in one color, without light. Nothing else of the pass
/// changes.
void setUnlitSection(Ogre::Pass* pass, const Ogre::ColourValue& color, const Section& section);

}  // namespace rviz_mesh_plugin
