#pragma once

#include <OgreColourValue.h>
#include <OgrePrerequisites.h>

namespace rviz_mesh_plugin {

/// The part of a surface's color that is seen where no light falls.
constexpr float AMBIENT_SHARE = 0.4f;

/// Makes a pass light faces from whichever side they are seen, by RViz's light (directional, along
/// the view): a surface that faces the camera has exactly its color, and AMBIENT_SHARE of it where
/// the light grazes.
///
/// The pass gets a pair of GLSL 1.20 programs, which all passes of this process share.
/// @param vertex_colors the color comes from the vertex buffer, else it is @a color everywhere
void setTwoSidedLighting(Ogre::Pass* pass, bool vertex_colors, const Ogre::ColourValue& color);

}  // namespace rviz_mesh_plugin
