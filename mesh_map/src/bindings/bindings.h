#pragma once

// What the files of bindings share, and what each adds to the module.

#include <pybind11/pybind11.h>

#include <atomic>

namespace mesh_map {

/// Bound as _CancelFlag. May be set from any thread, before or while what it is given to runs.
struct CancelFlag
{
  std::atomic<bool> flag{false};
};

inline const std::atomic<bool>* flagOf(const CancelFlag* cancel)
{
  return cancel == nullptr ? nullptr : &cancel->flag;
}

void bindMesh(pybind11::module_& module);
void bindDijkstra(pybind11::module_& module);
void bindObstacleDistance(pybind11::module_& module);
void bindFastMarching(pybind11::module_& module);
void bindQueryKernels(pybind11::module_& module);
void bindTraceKernels(pybind11::module_& module);
void bindSpatial(pybind11::module_& module);

}  // namespace mesh_map
