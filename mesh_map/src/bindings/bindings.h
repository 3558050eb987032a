#pragma once

// What the files of bindings share: checked arrays in, arrays out.

#include <mesh_map/base/array_view.h>

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <cxxabi.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <initializer_list>
#include <string>
#include <utility>
#include <vector>

namespace mesh_map {

namespace py = pybind11;

using Array = const py::array&;
using Object = const py::object&;

/// Any length, in the list of extents given to view().
constexpr py::ssize_t ANY = -1;

inline void requireValue(bool condition, const std::string& message)
{
  if (!condition) {
    throw py::value_error(message);
  }
}

/// The place of a name in a list, as a value of an enumeration of these; ValueError for another.
template <class Enumeration>
Enumeration choiceOf(const std::string& name, const std::array<const char*, 3>& names,
                     const char* what)
{
  const auto found = std::find(names.begin(), names.end(), name);
  requireValue(found != names.end(),
               std::string(what) + " has to be " + names[0] + ", " + names[1] + " or " + names[2]);
  return static_cast<Enumeration>(found - names.begin());
}

/// A view of a C-contiguous array of exactly this type and shape; ValueError for any other. The
/// array has to stay alive while the view is used: the arguments of a bound function do.
template <class T>
ArrayView<T> view(const py::array& array, const char* name,
                  std::initializer_list<py::ssize_t> shape)
{
  requireValue(py::isinstance<py::array_t<T>>(array),
               std::string(name) + " has to be an array of " +
                   py::cast<std::string>(py::str(py::dtype::of<T>())) + ", not of " +
                   py::cast<std::string>(py::str(array.dtype())));
  bool fits = array.ndim() == static_cast<py::ssize_t>(shape.size());
  std::string expected;
  py::ssize_t axis = 0;
  for (const py::ssize_t extent : shape) {
    fits = fits && (extent == ANY || array.shape(axis) == extent);
    expected += (axis++ > 0 ? ", " : "") + (extent == ANY ? "N" : std::to_string(extent));
  }
  requireValue(fits, std::string(name) + " has to have the shape (" + expected + "), not " +
                         py::cast<std::string>(py::str(array.attr("shape"))));
  requireValue((array.flags() & py::array::c_style) != 0,
               std::string(name) + " has to be contiguous in C order");
  return {static_cast<const T*>(array.data()), static_cast<std::size_t>(array.size())};
}

/// The same of an array, or of None, which is an empty one.
template <class T>
ArrayView<T> viewOrNone(const py::object& array, const char* name,
                        std::initializer_list<py::ssize_t> shape)
{
  return array.is_none() ? ArrayView<T>() : view<T>(py::cast<py::array>(array), name, shape);
}

/// ValueError unless all indices are below the limit.
inline void checkIndices(ArrayView<std::uint32_t> indices, std::size_t limit, const char* name)
{
  const auto* const wrong =
      std::find_if(indices.begin(), indices.end(), [limit](auto index) { return index >= limit; });
  if (wrong != indices.end()) {
    throw py::value_error(std::string(name) + " has the index " + std::to_string(*wrong) +
                          " at position " + std::to_string(wrong - indices.begin()) +
                          ", but only " + std::to_string(limit) + " exist");
  }
}

/// Checked indices below `limit`.
inline ArrayView<std::uint32_t> indexView(const py::array& array, std::size_t limit,
                                          const char* name)
{
  const auto indices = view<std::uint32_t>(array, name, {ANY});
  checkIndices(indices, limit, name);
  return indices;
}

/// Checked rows of indices below `limit`.
inline RowsView rowsView(const py::array& offsets, const py::array& values, std::size_t limit,
                         const char* name)
{
  const RowsView rows = {view<std::uint32_t>(offsets, "offsets", {ANY}),
                         view<std::uint32_t>(values, name, {ANY})};
  bool valid = !rows.offsets.empty() && rows.offsets[0] == 0 &&
               rows.offsets[rows.rowCount()] == rows.values.size();
  for (std::size_t i = 0; valid && i < rows.rowCount(); ++i) {
    valid = rows.offsets[i] <= rows.offsets[i + 1];
  }
  requireValue(valid, std::string("offsets do not divide ") + name + " into rows");
  checkIndices(rows.values, limit, name);
  return rows;
}

/// A checked mesh.
inline MeshView meshView(const py::array& vertices, const py::array& faces)
{
  const MeshView mesh = {view<float>(vertices, "vertices", {ANY, 3}),
                         view<std::uint32_t>(faces, "faces", {ANY, 3})};
  checkIndices(mesh.faces, mesh.vertexCount(), "faces");
  return mesh;
}

/// Three numbers.
template <class T>
std::array<T, 3> triple(const py::array& array, const char* name)
{
  const auto numbers = view<T>(array, name, {3});
  return {numbers[0], numbers[1], numbers[2]};
}

/// Without the GIL, while it lives: other threads of Python go on.
///
/// When the process ends, Python ends threads that want the GIL back, by pthread_exit(). That would
/// unwind through native code which takes it for an error, and abort the process: such a thread
/// sleeps until the process is gone.
class WithoutGil
{
 public:
  WithoutGil() : state_(PyEval_SaveThread()) {}
  WithoutGil(const WithoutGil&) = delete;
  WithoutGil& operator=(const WithoutGil&) = delete;
  ~WithoutGil()
  {
    try {
      PyEval_RestoreThread(state_);
    } catch (const abi::__forced_unwind&) {
      for (;;) {
        ::pause();
      }
    }
  }

 private:
  PyThreadState* state_;
};

/// What a function gives, which runs without the GIL.
template <class Function>
auto unlocked(const Function& function)
{
  const WithoutGil release;
  return function();
}

/// Gives the memory of a vector to a new array, without a copy.
template <class T, class A>
py::array_t<T> toArray(std::vector<T, A>&& values, std::vector<py::ssize_t> shape)
{
  auto* const owner = new std::vector<T, A>(std::move(values));
  const py::capsule capsule(owner,
                            [](void* memory) { delete static_cast<std::vector<T, A>*>(memory); });
  return py::array_t<T>(std::move(shape), owner->data(), capsule);
}

template <class T, class A>
py::array_t<T> toArray(std::vector<T, A>&& values)
{
  const auto size = static_cast<py::ssize_t>(values.size());
  return toArray(std::move(values), {size});
}

/// Memory of something as an array that cannot be written and keeps it alive.
template <class T>
py::array memoryOf(const py::object& owner, const T* data, std::vector<std::size_t> shape)
{
  py::array_t<T> array(std::move(shape), data, owner);
  array.attr("flags").attr("writeable") = false;
  return std::move(array);
}

/// A tuple of one array for each.
template <class... Vectors>
py::tuple toArrays(Vectors&&... values)
{
  return py::make_tuple(toArray(std::move(values))...);
}

/// Rows of `width` values each.
template <class T, class A>
py::array_t<T> toRows(std::vector<T, A>&& values, py::ssize_t width)
{
  const auto rows = static_cast<py::ssize_t>(values.size()) / width;
  return toArray(std::move(values), {rows, width});
}

/// Bound as _CancelFlag. May be set from any thread, before or while what it is given to runs.
struct CancelFlag
{
  std::atomic<bool> flag{false};
};

inline const std::atomic<bool>* flagOf(const CancelFlag* cancel)
{
  return cancel == nullptr ? nullptr : &cancel->flag;
}

/// What each file of bindings adds to the module.
void bindMesh(py::module_& module);
void bindCollision(py::module_& module);
void bindDijkstra(py::module_& module);
void bindObstacleDistance(py::module_& module);
void bindFastMarching(py::module_& module);
void bindQueryKernels(py::module_& module);
void bindTraceKernels(py::module_& module);
void bindReconstruction(py::module_& module);
void bindSignals(py::module_& module);
void bindSpatial(py::module_& module);
void bindRepair(py::module_& module);

}  // namespace mesh_map
