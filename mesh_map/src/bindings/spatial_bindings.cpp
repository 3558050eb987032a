// The spatial index for Python (private; see mesh_map.spatial_index): its making, rays, closest
// points and selections; and long runs that Python can interrupt.

#include "bindings/spatial_bindings.h"

#include <mesh_map/bvh/tree/back_end.h>

#include <chrono>
#include <exception>
#include <future>
#include <string>
#include <system_error>
#include <utility>

#include "base/vector3.h"

namespace mesh_map {

namespace {

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
  return resultOf({threads, cancel, progress}, mesh.faceCount(), [&](const BvhOptions& run) {
    return std::make_shared<Bvh>(Bvh::build(mesh, run));
  });
}

/// A copy with moved vertices: what is asked of the old one meanwhile is answered as before.
std::shared_ptr<Bvh> refitted(const Bvh& old, Array vertices, Array faces, unsigned threads,
                              const CancelFlag* cancel, Object progress)
{
  const MeshView mesh = uncheckedMesh(vertices, faces);
  return resultOf({threads, cancel, progress}, mesh.faceCount(), [&](const BvhOptions& run) {
    auto bvh = std::make_shared<Bvh>(old);
    bvh->refit(mesh, run);
    return bvh;
  });
}

py::bytes serialize(const Bvh& bvh)
{
  const std::vector<std::uint8_t> bytes = unlocked([&] { return bvh.serialize(); });
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
  const WithoutGil release;
  return std::make_shared<Bvh>(Bvh::deserialize(
      {reinterpret_cast<const std::uint8_t*>(bytes), static_cast<std::size_t>(size)}, mesh));
}

py::array nodes(Object self)
{
  const auto nodes = py::cast<const Bvh&>(self).nodes();
  const auto* const bytes = reinterpret_cast<const std::uint8_t*>(nodes.data());
  return memoryOf(self, bytes, {nodes.size(), sizeof(BvhNode)});
}

/// With the tail.
py::array corners(Object self)
{
  const auto corners = py::cast<const Bvh&>(self).corners();
  return memoryOf(self, corners.data(), {corners.size() + Bvh::TAIL});
}

py::array facesOf(Object self)
{
  const auto faces = py::cast<const Bvh&>(self).faces();
  return memoryOf(self, faces.data(), {faces.size()});
}

Ray rayOf(Object origin, Object direction, double max_distance)
{
  return {vector3(origin, "origin"), vector3(direction, "direction"), max_distance};
}

py::object cast(const Bvh& bvh, Object origin, Object direction, double max_distance,
                bool back_faces, Object mask)
{
  const Ray ray = rayOf(origin, direction, max_distance);
  const RayOptions options = rayOptions(bvh, back_faces, mask);
  const RayHit hit = unlocked([&] { return castRay(bvh, ray, options); });
  if (hit.face == NO_INDEX) {
    return py::none();
  }
  const Vector3 position = ray.origin + hit.distance * RayTest(ray).direction();
  return py::make_tuple(hit.face, toArray3(position), toArray3(hit.barycentric), hit.distance);
}

bool anyHit(const Bvh& bvh, Object origin, Object direction, double max_distance, bool back_faces,
            Object mask)
{
  const Ray ray = rayOf(origin, direction, max_distance);
  const RayOptions options = rayOptions(bvh, back_faces, mask);
  return unlocked([&] { return rayHitsAny(bvh, ray, options); });
}

py::tuple castBatch(const Bvh& bvh, Array origins, Array directions, Array max_distances,
                    bool back_faces, Object mask, unsigned threads, const CancelFlag* cancel)
{
  const RayBatch rays = rayBatch(origins, directions, max_distances);
  const RayOptions options = rayOptions(bvh, back_faces, mask);
  return toTuple(resultOf({threads, cancel}, rays.size(), [&](const BvhOptions& run) {
    return castRays(bvh, rays, options, run);
  }));
}

py::array anyHitBatch(const Bvh& bvh, Array origins, Array directions, Array max_distances,
                      bool back_faces, Object mask, unsigned threads, const CancelFlag* cancel)
{
  const RayBatch rays = rayBatch(origins, directions, max_distances);
  const RayOptions options = rayOptions(bvh, back_faces, mask);
  return toArray(resultOf({threads, cancel}, rays.size(), [&](const BvhOptions& run) {
    return raysHitAny(bvh, rays, options, run);
  }));
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
  const SurfaceHit hit = unlocked([&] { return closestPoint(bvh, query.data(), options); });
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
  return toTuple(resultOf({threads, cancel}, queries.size() / 3, [&](const BvhOptions& run) {
    return closestPoints(bvh, queries, options, run);
  }));
}

std::shared_ptr<Region> sphere(Object center, double radius)
{
  return std::make_shared<SphereRegion>(vector3(center, "center"), radius);
}

std::shared_ptr<Region> convex(Array planes)
{
  const auto numbers = view<double>(planes, "planes", {ANY, 4});
  std::vector<Plane> list;
  for (std::size_t i = 0; i < numbers.size(); i += 4) {
    list.push_back({numbers[i], numbers[i + 1], numbers[i + 2], numbers[i + 3]});
  }
  return std::make_shared<ConvexRegion>(list);
}

std::shared_ptr<Region> box(Object center, Array axes, Object half_size)
{
  const auto numbers = view<double>(axes, "axes", {3, 3});
  std::array<std::array<double, 3>, 3> rows;
  for (std::size_t i = 0; i < 9; ++i) {
    rows[i / 3][i % 3] = numbers[i];
  }
  return std::make_shared<ConvexRegion>(
      ConvexRegion::box(vector3(center, "center"), rows, vector3(half_size, "half_size")));
}

std::shared_ptr<Region> lasso(Array polygon, Array view_projection)
{
  const auto points = view<double>(polygon, "polygon", {ANY, 2});
  const auto numbers = view<double>(view_projection, "view_projection", {4, 4});
  std::vector<LassoRegion::Point> corners;
  for (std::size_t i = 0; i < points.size(); i += 2) {
    corners.push_back({points[i], points[i + 1]});
  }
  std::array<double, 16> matrix;
  std::copy(numbers.begin(), numbers.end(), matrix.begin());
  return std::make_shared<LassoRegion>(std::move(corners), matrix);
}

/// The kind of region that a function needs; ValueError for another.
template <class T>
const T& kind(const Region& region, const char* name)
{
  const T* const found = dynamic_cast<const T*>(&region);
  requireValue(found != nullptr, std::string("this needs a ") + name);
  return *found;
}

py::array select(const Bvh& bvh, const Region& region, bool inside, Object mask)
{
  const auto mask_view = maskView(bvh.faceCount(), mask);
  return toArray(unlocked([&] { return selectFaces(bvh, region, modeOf(inside), mask_view); }));
}

template <class T>
std::vector<T> copied(ArrayView<T> values)
{
  return {values.begin(), values.end()};
}

/// Values of a hit for each ray, from an array that Python gives.
template <class T>
std::vector<T> answer(const py::tuple& hits, std::size_t which, std::size_t count)
{
  const auto array = py::cast<py::array>(hits[which]);
  const auto size = static_cast<py::ssize_t>(count);
  return copied(which == 2 ? view<T>(array, "barycentric", {size, 3})
                           : view<T>(array, "hits", {size}));
}

/// Rays are cast by a function in Python, which takes origins, directions and maximum distances,
/// and gives faces, distances and barycentric coordinates.
RayCast rayCast(const py::function& cast)
{
  return [&cast](const RayBatch& rays) {
    const py::gil_scoped_acquire acquire;
    const auto hits = py::cast<py::tuple>(
        cast(toRows(copied(rays.origins), 3), toRows(copied(rays.directions), 3),
             rays.max_distances.empty() ? py::object(py::none())
                                        : py::object(toArray(copied(rays.max_distances)))));
    RayHits result;
    result.faces = answer<std::uint32_t>(hits, 0, rays.size());
    result.distances = answer<double>(hits, 1, rays.size());
    result.barycentric = answer<double>(hits, 2, rays.size());
    return result;
  };
}

py::array seen(const Bvh& bvh, const Region& region, Array faces, Object eye,
               const py::function& cast)
{
  const auto candidates = indexView(faces, bvh.faceCount(), "faces");
  const std::array<double, 3> from = vector3(eye, "eye");
  const RayCast cast_rays = rayCast(cast);
  return toArray(unlocked([&] { return seenFaces(bvh, region, candidates, from, cast_rays); }));
}

py::array inPicture(const Bvh& bvh, const Region& region, Array origins, Array directions,
                    Object mask, const py::function& cast)
{
  const RayBatch pixels = rayBatch(origins, directions, toArray(std::vector<double>()));
  const auto mask_view = maskView(bvh.faceCount(), mask);
  const RayCast cast_rays = rayCast(cast);
  return toArray(
      unlocked([&] { return facesInPicture(bvh, region, pixels, mask_view, cast_rays); }));
}

py::tuple toTuple(PixelRays&& rays)
{
  return py::make_tuple(toRows(std::move(rays.origins), 3), toRows(std::move(rays.directions), 3));
}

py::tuple pixelsOfFrustum(const Region& region, Object eye, std::size_t columns, std::size_t rows)
{
  const auto& frustum = kind<ConvexRegion>(region, "frustum");
  const std::array<double, 3> from = vector3(eye, "eye");
  return toTuple(unlocked([&] { return frustumPixels(frustum, from, columns, rows); }));
}

py::tuple pixelsOfLasso(const Region& region, std::size_t columns, std::size_t rows)
{
  const auto& lasso = kind<LassoRegion>(region, "lasso");
  return toTuple(unlocked([&] { return lassoPixels(lasso, columns, rows); }));
}

/// Canceled becomes mesh_map.errors.Canceled.
void translateCanceled(std::exception_ptr error)
{
  try {
    if (error) {
      std::rethrow_exception(error);
    }
  } catch (const Canceled& canceled) {
    const py::object type = py::module_::import("mesh_map.errors").attr("Canceled");
    PyErr_SetString(type.ptr(), canceled.what());
  }
}

}  // namespace

void bindSpatial(py::module_& module)
{
  py::register_exception_translator(&translateCanceled);
  BvhClass bvh(module, "_Bvh", py::module_local());
  bvh.def_static("_build", &build)
      .def("_refitted", &refitted)
      .def("_serialize", &serialize)
      .def_static("_deserialize", &deserialize)
      .def_property_readonly("_nodes", &nodes)
      .def_property_readonly("_corners", &corners)
      .def_property_readonly("_faces", &facesOf)
      .def_property_readonly("_face_count", &Bvh::faceCount)
      .def_property_readonly("_memory", &Bvh::memory)
      .def("_cast", &cast)
      .def("_any_hit", &anyHit)
      .def("_cast_batch", &castBatch)
      .def("_any_hit_batch", &anyHitBatch)
      .def("_closest", &closest)
      .def("_closest_batch", &closestBatch);
  py::class_<Region, std::shared_ptr<Region>>(module, "_Region", py::module_local());
  module.def("_sphere", &sphere);
  module.def("_convex", &convex);
  module.def("_box", &box);
  module.def("_lasso", &lasso);
  module.def("_frustum_pixels", &pixelsOfFrustum);
  module.def("_lasso_pixels", &pixelsOfLasso);
  bvh.def("_select", &select).def("_seen", &seen).def("_in_picture", &inPicture);
  bindDevice(module, bvh);
}

namespace {

constexpr std::chrono::milliseconds TICK(5);
constexpr unsigned TICKS_PER_SIGNAL = 4;

/// Where no thread is to be had, the work is done when its end is waited for: it cannot be
/// interrupted then.
std::future<void> inItsOwnThread(const std::function<void()>& work)
{
  try {
    return std::async(std::launch::async, work);
  } catch (const std::system_error&) {
    return std::async(std::launch::deferred, work);
  }
}

/// A value in one line of an error, not too long.
std::string shown(const py::object& value)
{
  const py::object words = py::str(" ").attr("join")(py::repr(value).attr("split")());
  return py::cast<std::string>(words[py::slice(0, 100, 1)]);
}

}  // namespace

void runLong(const RunArguments& arguments, std::size_t items,
             const std::function<void(const BvhOptions& run)>& work)
{
  BvhOptions run;
  run.threads = arguments.threads;
  if (items < MANY_ITEMS && arguments.progress.is_none()) {
    run.cancel = flagOf(arguments.cancel);
    const WithoutGil release;
    work(run);
    return;
  }
  std::atomic<bool> stop{arguments.cancel && arguments.cancel->flag};
  run.cancel = &stop;
  std::exception_ptr raised;  // what Python code has raised first; touched with the GIL held
  const auto callPython = [&](const auto& call) {
    const py::gil_scoped_acquire acquire;
    try {
      if (!raised) {
        call();
      }
    } catch (const py::error_already_set&) {
      raised = raised ? raised : std::current_exception();
      stop = true;
    }
  };
  if (!arguments.progress.is_none()) {
    run.progress = [&](double fraction) { callPython([&] { arguments.progress(fraction); }); };
  }
  std::exception_ptr failed;
  {
    const WithoutGil release;
    try {
      std::future<void> ended = inItsOwnThread([&] { work(run); });
      for (unsigned tick = 1; ended.wait_for(TICK) == std::future_status::timeout; ++tick) {
        if (arguments.cancel && arguments.cancel->flag) {
          stop = true;
        }
        if (tick % TICKS_PER_SIGNAL == 0) {
          callPython([] {
            if (PyErr_CheckSignals() != 0) {
              throw py::error_already_set();
            }
          });
        }
      }
      ended.get();
    } catch (...) {
      failed = std::current_exception();
    }
  }
  if (raised || failed) {
    std::rethrow_exception(raised ? raised : failed);
  }
}

std::array<double, 3> vector3(const py::object& values, const char* name)
{
  using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;
  const auto given = py::array::ensure(values);
  const bool numbers = given && std::string("fiu").find(given.dtype().kind()) != std::string::npos;
  const auto array = numbers ? Doubles::ensure(given) : Doubles();
  if (!numbers || !array || array.ndim() != 1 || array.size() != 3) {
    throw py::value_error(std::string(name) + " has to be 3 numbers, not " + shown(values));
  }
  return {array.data()[0], array.data()[1], array.data()[2]};
}

py::array_t<double> toArray3(const std::array<double, 3>& values)
{
  return py::array_t<double>(3, values.data());
}

ArrayView<std::uint8_t> maskView(std::size_t face_count, const py::object& mask)
{
  return viewOrNone<std::uint8_t>(mask, "mask", {static_cast<py::ssize_t>(face_count)});
}

RayOptions rayOptions(const Bvh& bvh, bool back_faces, const py::object& mask)
{
  return {back_faces, maskView(bvh.faceCount(), mask)};
}

RayBatch rayBatch(const py::array& origins, const py::array& directions,
                  const py::array& max_distances)
{
  RayBatch rays;
  rays.directions = view<double>(directions, "directions", {ANY, 3});
  rays.origins = view<double>(origins, "origins", {ANY, 3});
  rays.max_distances = view<double>(max_distances, "max_distances", {ANY});
  if (rays.size() > 0) {
    rays.check();
  }
  return rays;
}

ClosestOptions closestOptions(const Bvh& bvh, double max_distance, const py::object& normals,
                              double max_angle, const py::object& mask)
{
  ClosestOptions options;
  options.max_distance = max_distance;
  options.max_angle = max_angle;
  options.normals = viewOrNone<double>(normals, "normals", {ANY, 3});
  options.mask = maskView(bvh.faceCount(), mask);
  return options;
}

py::tuple toTuple(RayHits&& hits)
{
  return py::make_tuple(toArray(std::move(hits.faces)), toArray(std::move(hits.distances)),
                        toRows(std::move(hits.barycentric), 3));
}

py::tuple toTuple(SurfaceHits&& hits)
{
  return py::make_tuple(toArray(std::move(hits.faces)), toRows(std::move(hits.positions), 3),
                        toRows(std::move(hits.barycentric), 3), toArray(std::move(hits.distances)));
}

}  // namespace mesh_map
