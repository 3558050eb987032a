// The spatial index for Python (private; see mesh_map.spatial_index): its making, rays and closest
// points; and long runs that Python can interrupt.

#include "bindings/spatial_bindings.h"

#include <mesh_map/bvh/tree/back_end.h>

#include <chrono>
#include <cmath>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <string>
#include <system_error>
#include <thread>
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
  using py::arg;

  py::register_exception_translator(&translateCanceled);
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

namespace {

constexpr std::chrono::milliseconds TICK(5);
constexpr unsigned TICKS_PER_SIGNAL = 4;

/// Runs work in a thread of its own, and tells when it has ended.
class Worker
{
 public:
  explicit Worker(const std::function<void()>& work)
  {
    const auto body = [this, &work] {
      try {
        work();
      } catch (...) {
        error_ = std::current_exception();
      }
      const std::lock_guard<std::mutex> lock(mutex_);
      ended_ = true;
      changed_.notify_all();
    };
    try {
      thread_ = std::thread(body);
    } catch (const std::system_error&) {
      body();  // no thread is to be had: it cannot be interrupted then
    }
  }

  ~Worker()
  {
    if (thread_.joinable()) {
      thread_.join();
    }
  }

  bool waitFor(std::chrono::milliseconds time)
  {
    std::unique_lock<std::mutex> lock(mutex_);
    return changed_.wait_for(lock, time, [this] { return ended_; });
  }

  /// Once it has ended.
  void rethrow() const
  {
    if (error_) {
      std::rethrow_exception(error_);
    }
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  bool ended_ = false;
  std::exception_ptr error_;
  std::thread thread_;
};

/// What Python code has raised, once.
class PythonError
{
 public:
  /// With the GIL held.
  void catchCurrent()
  {
    if (!error_) {
      error_ = std::current_exception();
    }
  }
  explicit operator bool() const { return error_ != nullptr; }

  /// With the GIL held: the error goes with this.
  void rethrow()
  {
    if (error_) {
      std::rethrow_exception(std::exchange(error_, nullptr));
    }
  }

 private:
  std::exception_ptr error_;
};

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
    const py::gil_scoped_release release;
    work(run);
    return;
  }
  std::atomic<bool> stop{arguments.cancel && arguments.cancel->flag};
  run.cancel = &stop;
  PythonError raised;
  if (!arguments.progress.is_none()) {
    run.progress = [&](double fraction) {
      const py::gil_scoped_acquire acquire;
      try {
        if (!raised) {
          arguments.progress(fraction);
        }
      } catch (const py::error_already_set&) {
        raised.catchCurrent();
        stop = true;
      }
    };
  }
  std::exception_ptr failed;
  {
    const py::gil_scoped_release release;
    try {
      const std::function<void()> body = [&] { work(run); };
      Worker worker(body);
      for (unsigned tick = 1; !worker.waitFor(TICK); ++tick) {
        if (arguments.cancel && arguments.cancel->flag) {
          stop = true;
        }
        if (tick % TICKS_PER_SIGNAL == 0) {
          const py::gil_scoped_acquire acquire;
          try {
            if (!raised && PyErr_CheckSignals() != 0) {
              throw py::error_already_set();
            }
          } catch (const py::error_already_set&) {
            raised.catchCurrent();
            stop = true;
          }
        }
      }
      worker.rethrow();
    } catch (...) {
      failed = std::current_exception();
    }
  }
  raised.rethrow();
  if (failed) {
    std::rethrow_exception(failed);
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
