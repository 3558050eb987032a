#pragma once

#include <functional>
#include <memory>

#include "rviz_mesh_plugin/opencl_program.h"

namespace rviz_mesh_plugin {

/// Launches every kernel on a small mesh, and compares its answers with the native ones. That also
/// takes the time of the first launch, in which some drivers compile, out of the first query.
/// Throws std::runtime_error where they differ, cl::Error, or what `go_on` throws, which is called
/// between them.
void checkDevice(const std::shared_ptr<const OpenClProgram>& program,
                 const std::function<void()>& go_on);

}  // namespace rviz_mesh_plugin
