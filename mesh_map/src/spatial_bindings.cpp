// The spatial index for Python (private; see mesh_map.spatial_index): its making, rays and closest
// points.

#include "spatial_bindings.h"

#include <mesh_map/back_end.h>

#include <cmath>
#include <string>
#include <utility>

namespace mesh_map {

namespace {

using Array = const py::array&;
using Object = const py::object&;

RunArguments runArguments(unsigned threads, const CancelFlag* cancel, py::object progress)
{
  return {threads, cancel, std::move(progress)};
}

/// Not meshView(): Bvh checks indices itself, on all threads.
MeshView uncheckedMesh(Array vertices, Array faces)
{
  return {view<float>(vertices, "vertices", {ANY, 3}),
          view<std::uint32_t>(faces, "faces", {ANY, 3})};
}

std::shared_ptr<Bvh> build(Array vertices, Array faces, unsigned threads, const CancelFlag* cancel,
                           Object progress)
{
  const MeshView mesh = uncheckedMesh(vertices, faces);
  std::shared_ptr<Bvh> bvh;
  runLong(runArguments(threads, cancel, progress), mesh.faceCount(),
          [&](const BvhOptions& run) { bvh = std::make_shared<Bvh>(Bvh::build(mesh, run)); });
  return bvh;
}

/// A copy with moved vertices: what is asked of the old one meanwhile is answered as before.
std::shared_ptr<Bvh> refitted(const Bvh& old, Array vertices, Array faces, unsigned threads,
                              const CancelFlag* cancel, Object progress)
{
  const MeshView mesh = uncheckedMesh(vertices, faces);
  std::shared_ptr<Bvh> bvh;
  runLong(runArguments(threads, cancel, progress), mesh.faceCount(), [&](const BvhOptions& run) {
    bvh = std::make_shared<Bvh>(old);
    bvh->refit(mesh, run);
  });
  return bvh;
}

py::bytes serialize(const Bvh& bvh)
{
  std::vector<std::uint8_t> bytes;
  {
    const py::gil_scoped_release release;
    bytes = bvh.serialize();
  }
  return py::bytes(reinterpret_cast<const char*>(bytes.data()), bytes.size());
}

std::shared_ptr<Bvh> deserialize(const py::bytes& data, Array vertices, Array faces)
{
  const MeshView mesh = uncheckedMesh(vertices, faces);
  char* bytes = nullptr;
  py::ssize_t size = 0;
  if (PyBytes_AsStringAndSize(data.ptr(), &bytes, &size) != 0) {
    throw py::error_already_set();
  }
  const py::gil_scoped_release release;
  return std::make_shared<Bvh>(Bvh::deserialize(
      {reinterpret_cast<const std::uint8_t*>(bytes), static_cast<std::size_t>(size)}, mesh));
}

/// Memory of the hierarchy as an array that cannot be written and keeps it alive.
template <class T>
py::array memoryOf(Object owner, const void* data, std::vector<py::ssize_t> shape)
{
  py::array array(py::dtype::of<T>(), std::move(shape), data, owner);
  array.attr("flags").attr("writeable") = false;
  return array;
}

py::array nodes(Object self)
{
  const auto nodes = py::cast<const Bvh&>(self).nodes();
  return memoryOf<std::uint8_t>(
      self, nodes.data(),
      {static_cast<py::ssize_t>(nodes.size()), static_cast<py::ssize_t>(sizeof(BvhNode))});
}

/// With the tail.
py::array corners(Object self)
{
  const auto corners = py::cast<const Bvh&>(self).corners();
  return memoryOf<float>(self, corners.data(),
                         {static_cast<py::ssize_t>(corners.size() + Bvh::TAIL)});
}

py::array facesOf(Object self)
{
  const auto faces = py::cast<const Bvh&>(self).faces();
  return memoryOf<std::uint32_t>(self, faces.data(), {static_cast<py::ssize_t>(faces.size())});
}

py::array_t<double> toArray3(const std::array<double, 3>& values)
{
  return py::array_t<double>(3, values.data());
}

Ray rayOf(Object origin, Object direction, double max_distance)
{
  return {vector3(origin, "origin"), vector3(direction, "direction"), max_distance};
}

py::object cast(const Bvh& bvh, Object origin, Object direction, double max_distance,
                bool back_faces, Object mask)
{
  const Ray ray = rayOf(origin, direction, max_distance);
  const RayOptions options{back_faces, maskView(bvh, mask)};
  RayHit hit;
  {
    const py::gil_scoped_release release;
    hit = castRay(bvh, ray, options);
  }
  if (hit.face == NO_INDEX) {
    return py::none();
  }
  std::array<double, 3> position = RayTest(ray).direction();
  for (std::size_t k = 0; k < 3; ++k) {
    position[k] = ray.origin[k] + hit.distance * position[k];
  }
  return py::make_tuple(hit.face, toArray3(position), toArray3(hit.barycentric), hit.distance);
}

bool anyHit(const Bvh& bvh, Object origin, Object direction, double max_distance, bool back_faces,
            Object mask)
{
  const Ray ray = rayOf(origin, direction, max_distance);
  const RayOptions options{back_faces, maskView(bvh, mask)};
  const py::gil_scoped_release release;
  return rayHitsAny(bvh, ray, options);
}

py::tuple castBatch(const Bvh& bvh, Array origins, Array directions, Array max_distances,
                    bool back_faces, Object mask, unsigned threads, const CancelFlag* cancel)
{
  const RayBatch rays = rayBatch(origins, directions, max_distances);
  const RayOptions options{back_faces, maskView(bvh, mask)};
  RayHits hits;
  runLong(runArguments(threads, cancel, py::none()), rays.size(),
          [&](const BvhOptions& run) { hits = castRays(bvh, rays, options, run); });
  return toTuple(std::move(hits));
}

py::array anyHitBatch(const Bvh& bvh, Array origins, Array directions, Array max_distances,
                      bool back_faces, Object mask, unsigned threads, const CancelFlag* cancel)
{
  const RayBatch rays = rayBatch(origins, directions, max_distances);
  const RayOptions options{back_faces, maskView(bvh, mask)};
  std::vector<std::uint8_t> hits;
  runLong(runArguments(threads, cancel, py::none()), rays.size(),
          [&](const BvhOptions& run) { hits = raysHitAny(bvh, rays, options, run); });
  return toArray(std::move(hits));
}

py::object closest(const Bvh& bvh, Object point, double max_distance, Object normal,
                   double max_angle, Object mask)
{
  const std::array<double, 3> query = vector3(point, "point");
  std::array<double, 3> direction{};
  ClosestOptions options = closestOptions(bvh, max_distance, py::none(), max_angle, mask);
  if (!normal.is_none()) {
    direction = vector3(normal, "normal");
    options.normals = {direction.data(), 3};
  }
  SurfaceHit hit;
  {
    const py::gil_scoped_release release;
    hit = closestPoint(bvh, query.data(), options);
  }
  if (hit.face == NO_INDEX) {
    return py::none();
  }
  return py::make_tuple(hit.face, toArray3(hit.position), toArray3(hit.barycentric), hit.distance);
}

py::tuple closestBatch(const Bvh& bvh, Array points, double max_distance, Object normals,
                       double max_angle, Object mask, unsigned threads, const CancelFlag* cancel)
{
  const auto queries = view<double>(points, "points", {ANY, 3});
  const ClosestOptions options = closestOptions(bvh, max_distance, normals, max_angle, mask);
  SurfaceHits hits;
  runLong(runArguments(threads, cancel, py::none()), queries.size() / 3,
          [&](const BvhOptions& run) { hits = closestPoints(bvh, queries, options, run); });
  return toTuple(std::move(hits));
}

/// Cancelled becomes mesh_map.errors.Cancelled.
void translateCancelled(std::exception_ptr error)
{
  try {
    if (error) {
      std::rethrow_exception(error);
    }
  } catch (const Cancelled& cancelled) {
    const py::object type = py::module_::import("mesh_map.errors").attr("Cancelled");
    PyErr_SetString(type.ptr(), cancelled.what());
  }
}

}  // namespace

void bindSpatial(py::module_& module)
{
  using py::arg;

  py::register_exception_translator(&translateCancelled);
  BvhClass bvh(module, "_Bvh", py::module_local());
  bvh.def_static("_build", &build, arg("vertices"), arg("faces"), arg("threads"), arg("cancel"),
                 arg("progress"))
      .def("_refitted", &refitted, arg("vertices"), arg("faces"), arg("threads"), arg("cancel"),
           arg("progress"))
      .def("_serialize", &serialize)
      .def_static("_deserialize", &deserialize, arg("data"), arg("vertices"), arg("faces"))
      .def_property_readonly("_nodes", &nodes)
      .def_property_readonly("_corners", &corners)
      .def_property_readonly("_faces", &facesOf)
      .def_property_readonly(
          "_center",
          [](const Bvh& self) {
            return toArray3({self.center()[0], self.center()[1], self.center()[2]});
          })
      .def_property_readonly("_face_count", &Bvh::faceCount)
      .def_property_readonly("_memory", &Bvh::memory)
      .def("_cast", &cast, arg("origin"), arg("direction"), arg("max_distance"), arg("back_faces"),
           arg("mask"))
      .def("_any_hit", &anyHit, arg("origin"), arg("direction"), arg("max_distance"),
           arg("back_faces"), arg("mask"))
      .def("_cast_batch", &castBatch, arg("origins"), arg("directions"), arg("max_distances"),
           arg("back_faces"), arg("mask"), arg("threads"), arg("cancel"))
      .def("_any_hit_batch", &anyHitBatch, arg("origins"), arg("directions"), arg("max_distances"),
           arg("back_faces"), arg("mask"), arg("threads"), arg("cancel"))
      .def("_closest", &closest, arg("point"), arg("max_distance"), arg("normal"), arg("max_angle"),
           arg("mask"))
      .def("_closest_batch", &closestBatch, arg("points"), arg("max_distance"), arg("normals"),
           arg("max_angle"), arg("mask"), arg("threads"), arg("cancel"));
  bindRegions(module, bvh);
  bindDevice(module, bvh);
}

}  // namespace mesh_map
