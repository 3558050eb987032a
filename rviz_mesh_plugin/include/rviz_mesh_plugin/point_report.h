#pragma once

#include <string>

#ifndef Q_MOC_RUN
#include "rviz_mesh_plugin/point_values.h"
#include "rviz_mesh_plugin/surface_picker.h"
#endif

namespace rviz {
class DisplayContext;
}

namespace rviz_mesh_plugin {

/// What the displays that are enabled know of a point: layers and labels of all that show its mesh.
PointReport reportAt(const SurfaceHit& hit, rviz::DisplayContext& context);

}  // namespace rviz_mesh_plugin
