#pragma once

// What the files of bindings of the spatial index share.

#include <mesh_map/bvh/closest/bvh_closest.h>
#include <mesh_map/bvh/rays/bvh_rays.h>
#include <mesh_map/bvh/selection/bvh_selection.h>
#include <mesh_map/bvh/tree/bvh.h>

#include <pybind11/pybind11.h>

#include <array>
#include <cstddef>
#include <functional>
#include <memory>
#include <utility>

#include "bindings/bindings.h"

namespace mesh_map {

using BvhClass = py::class_<Bvh, std::shared_ptr<Bvh>>;

/// How Python asks for something long.
struct RunArguments
{
  unsigned threads = 0;
  const CancelFlag* cancel = nullptr;
  py::object progress =
      py::none();  ///< called with the share that is done; what it raises ends all
};

/// Runs something long with the GIL released. Where there is much to do (`items`), it runs in
/// another thread, while this one looks for signals: what their handlers raise (KeyboardInterrupt)
/// ends it within milliseconds, and is then thrown. No thread is left in any case.
void runLong(const RunArguments& arguments, std::size_t items,
             const std::function<void(const BvhOptions& run)>& work);

/// What something long gives, run so.
template <class Work>
auto resultOf(const RunArguments& arguments, std::size_t items, const Work& work)
{
  decltype(work(std::declval<const BvhOptions&>())) result;
  runLong(arguments, items, [&](const BvhOptions& run) { result = work(run); });
  return result;
}

/// Items from which on runLong() looks for signals: below, all is done in some milliseconds.
constexpr std::size_t MANY_ITEMS = 4096;

/// Three numbers in any form; ValueError for anything else.
std::array<double, 3> vector3(const py::object& values, const char* name);

/// The same as an array.
py::array_t<double> toArray3(const std::array<double, 3>& values);

/// (F,) uint8, or None: all count.
ArrayView<std::uint8_t> maskView(std::size_t face_count, const py::object& mask);

/// Whether all of a face has to be in a region that selects it.
inline SelectionMode modeOf(bool inside)
{
  return inside ? SelectionMode::INSIDE : SelectionMode::TOUCHING;
}

RayOptions rayOptions(const Bvh& bvh, bool back_faces, const py::object& mask);

/// Arrays of a batch of rays: (N, 3) or (1, 3), (N, 3), and (N,) or (1,) doubles.
RayBatch rayBatch(const py::array& origins, const py::array& directions,
                  const py::array& max_distances);

/// `normals` are (N, 3) or (1, 3) doubles or None.
ClosestOptions closestOptions(const Bvh& bvh, double max_distance, const py::object& normals,
                              double max_angle, const py::object& mask);

/// Tuples of arrays.
py::tuple toTuple(RayHits&& hits);
py::tuple toTuple(SurfaceHits&& hits);

void bindDevice(py::module_& module, BvhClass& bvh);

}  // namespace mesh_map
