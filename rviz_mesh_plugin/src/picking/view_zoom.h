#pragma once

#include <OgreAxisAlignedBox.h>

#ifndef Q_MOC_RUN
#include "base/bounds.h"
#include "mesh_view/shown_mesh.h"
#endif

namespace rviz {
class ViewController;
}

namespace rviz_mesh_plugin {

/// A box of a mesh in the fixed frame.
Ogre::AxisAlignedBox boxInFixedFrame(const Bounds& bounds, const ShownMesh& mesh);

/// Moves a camera of RViz so that it sees all of a box and little else, in the direction that it
/// looks to; by the properties of its view, which are saved with it. Views that turn about a point
/// (Orbit, XYOrbit, ThirdPersonFollower) take the middle of the box for it, those from above move
/// and change their scale, FPS goes where the box is seen from. Any other view looks at the middle.
/// @return false: it is behind the camera, as above that of TopDownOrtho
bool zoomTo(rviz::ViewController& view, const Ogre::AxisAlignedBox& box);

}  // namespace rviz_mesh_plugin
