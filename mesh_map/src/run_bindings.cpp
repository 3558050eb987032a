// Long runs that Python can interrupt, and the arguments of the bindings of the spatial index.

#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <string>
#include <system_error>
#include <thread>
#include <utility>

#include "spatial_bindings.h"

namespace mesh_map {

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
    run.cancel = arguments.cancel ? &arguments.cancel->flag : nullptr;
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

ArrayView<std::uint8_t> maskView(const Bvh& bvh, const py::object& mask)
{
  if (mask.is_none()) {
    return {};
  }
  return view<std::uint8_t>(py::cast<py::array>(mask), "mask",
                            {static_cast<py::ssize_t>(bvh.faceCount())});
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
  if (!normals.is_none()) {
    options.normals = view<double>(py::cast<py::array>(normals), "normals", {ANY, 3});
  }
  options.mask = maskView(bvh, mask);
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
