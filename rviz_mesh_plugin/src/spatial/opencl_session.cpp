#include "spatial/opencl_session.h"

#include <mesh_map/bvh/device/bvh_device.h>
#include <mesh_map/bvh/rays/bvh_rays.h>
#include <mesh_map/bvh/selection/bvh_selection.h>

#include <cmath>
#include <map>
#include <set>
#include <stdexcept>
#include <utility>
#include <vector>

#include "spatial/device_queries.h"
#include "spatial/opencl_program.h"

namespace rviz_mesh_plugin {
namespace {

using Key = std::pair<std::string, std::string>;  // wish, folder of the cache

struct Registry
{
  std::mutex mutex;
  std::map<Key, std::weak_ptr<OpenClSession>> sessions;
  std::set<Key> failed;  // did not start
};

/// Never destroyed: sessions may outlive any static object.
Registry& registry()
{
  static Registry& registry = *new Registry;
  return registry;
}

std::string nativeInstead(const std::string& why)
{
  return "OpenCL: " + why + "; queries are answered natively";
}

/// The beginning of what a compiler said, in one line.
std::string excerpt(const cl::BuildError& error)
{
  std::string log;
  for (const auto& of_device : error.getBuildLog()) {
    log += of_device.second;
  }
  for (char& c : log) {
    c = c == '\n' || c == '\0' ? ' ' : c;
  }
  return log.substr(0, 500);
}

/// Its index in `devices`; throws std::runtime_error where there is none.
std::size_t choose(const std::vector<cl::Device>& devices, const std::string& wish)
{
  std::vector<DeviceInfo> infos;
  std::string names;
  for (const cl::Device& device : devices) {
    infos.push_back(describe(device));
    names += (names.empty() ? "" : ", ") + infos.back().text();
  }
  if (infos.empty()) {
    throw std::runtime_error("no device is usable");
  }
  const auto chosen = chooseDevice(infos, wish);
  if (!chosen) {
    throw std::runtime_error("no device is '" + wish + "' (there is " + names +
                             "; see MESH_TOOLS_OPENCL)");
  }
  return *chosen;
}

constexpr unsigned CELLS = 16;  // per side

/// A wavy square from 0 to CELLS.
mesh_map::Bvh smallMesh()
{
  std::vector<float> positions;
  std::vector<std::uint32_t> faces;
  for (unsigned i = 0; i <= CELLS; ++i) {
    for (unsigned j = 0; j <= CELLS; ++j) {
      const float x = static_cast<float>(i), y = static_cast<float>(j);
      positions.insert(positions.end(), {x, y, std::sin(0.7f * x) * std::cos(0.5f * y)});
      if (i < CELLS && j < CELLS) {
        const unsigned a = i * (CELLS + 1) + j, b = a + CELLS + 1;
        faces.insert(faces.end(), {a, b, a + 1, a + 1, b, b + 1});
      }
    }
  }
  return mesh_map::Bvh::build({positions, faces});
}

void expect(bool same, const char* what)
{
  if (!same) {
    throw std::runtime_error(std::string("the device computes ") + what + " wrongly");
  }
}

bool operator==(const mesh_map::RayHits& a, const mesh_map::RayHits& b)
{
  return a.faces == b.faces && a.distances == b.distances && a.barycentric == b.barycentric;
}

/// Launches every kernel that queries use on a small mesh, and compares its answers with the native
/// ones. That also takes the time of the first launch, in which some drivers compile, out of the
/// first query. Throws std::runtime_error where they differ, cl::Error, or what `go_on` throws,
/// which is called between them.
void checkDevice(const std::shared_ptr<const OpenClProgram>& program,
                 const std::function<void()>& go_on)
{
  const mesh_map::Bvh bvh = smallMesh();
  const DeviceQueries device(program, bvh);
  std::vector<double> points, directions;
  for (unsigned i = 0; i < 300; ++i) {  // the last fifth beside the mesh
    points.insert(points.end(), {0.07 * i, 0.05 * (i * 37 % 300), 3.0});
    directions.insert(directions.end(), {0.3, -0.2, -1.0});
  }
  const mesh_map::RayBatch rays{points, directions, {}};
  mesh_map::RayHits hits;
  device.castRays(rays, {}, hits);
  expect(hits == mesh_map::castRays(bvh, rays), "rays");

  const mesh_map::SphereRegion sphere({5.0, 6.0, 0.0}, 3.0);
  const auto box = mesh_map::ConvexRegion::box(
      {8.0, 8.0, 0.0}, {{{0.8, 0.6, 0.0}, {-0.6, 0.8, 0.0}, {0.0, 0.0, 1.0}}}, {5.0, 3.0, 0.5});
  for (const mesh_map::Region* region : {static_cast<const mesh_map::Region*>(&sphere),
                                         static_cast<const mesh_map::Region*>(&box)}) {
    go_on();
    expect(device.selectFaces(*region, mesh_map::selectionRoots(bvh, *region), {}) ==
               mesh_map::selectFaces(bvh, *region),
           "selections");
  }
}

}  // namespace

std::shared_ptr<OpenClSession> OpenClSession::shared(const std::string& wish,
                                                     const std::string& cache_folder,
                                                     LogFunction log)
{
  Registry& all = registry();
  const std::lock_guard<std::mutex> lock(all.mutex);
  const Key key(wish, cache_folder);
  std::shared_ptr<OpenClSession> session = all.sessions[key].lock();
  if (session && session->state() != State::UNUSABLE) {
    return session;
  }
  const std::shared_ptr<OpenClSession> started(
      new OpenClSession(wish, cache_folder, std::move(log)));
  // Its thread keeps it until it has ended. The last user waits for that: drivers and compilers
  // must not work while the end of the process takes their libraries down.
  session.reset(started.get(), [kept = started](OpenClSession* abandoned) mutable {
    abandoned->thread_.join();
    kept.reset();  // the registry's weak pointer would keep it
  });
  if (all.failed.count(key) != 0) {
    session->end(State::UNUSABLE);
    return session;
  }
  all.sessions[key] = session;
  try {
    session->thread_.add(
        [started](const Cancellation& cancellation) { started->run(cancellation); });
  } catch (const std::system_error& error) {
    session->end(State::UNUSABLE);
    session->log(LogLevel::WARNING, nativeInstead(error.what()));
  }
  return session;
}

OpenClSession::OpenClSession(std::string wish, const std::string& cache_folder, LogFunction log)
    : wish_(std::move(wish)), cache_folder_(cache_folder), log_(std::move(log))
{
}

bool OpenClSession::wait() const
{
  std::unique_lock<std::mutex> lock(mutex_);
  ended_.wait(lock, [this] { return state_ != State::STARTING; });
  return state_ == State::READY;
}

std::shared_ptr<const OpenClProgram> OpenClSession::program() const
{
  const std::lock_guard<std::mutex> lock(mutex_);
  return program_;
}

void OpenClSession::fail(const std::string& why)
{
  if (state_.exchange(State::UNUSABLE) != State::UNUSABLE) {
    end(State::UNUSABLE);
    log(LogLevel::WARNING, nativeInstead(why));
  }
}

void OpenClSession::run(const Cancellation& cancellation)
{
  std::string why;
  try {
    const auto program = start(cancellation);
    log(LogLevel::INFO, "OpenCL: batches of queries are answered by " + program->info.text() +
                            ", program " + (program->from_cache ? "from the cache" : "compiled"));
    end(State::READY, program);
    return;
  } catch (const Canceled&) {
    end(State::UNUSABLE);
    return;
  } catch (const cl::BuildError& error) {
    why = describe(error) + ": " + excerpt(error);
  } catch (const cl::Error& error) {
    why = describe(error);
  } catch (const std::exception& error) {
    why = error.what();
  }
  {
    Registry& all = registry();
    const std::lock_guard<std::mutex> lock(all.mutex);
    all.failed.insert({wish_, cache_folder_});
  }
  log(LogLevel::WARNING, nativeInstead(why));
  end(State::UNUSABLE);
}

std::shared_ptr<const OpenClProgram> OpenClSession::start(const Cancellation& cancellation) const
{
  const auto go_on = [&] { throwIfCanceled(&cancellation.flag()); };
  const ProgramCache cache(cache_folder_);
  const std::vector<cl::Device> devices = listDevices();
  const cl::Device& device = devices.at(choose(devices, wish_));
  go_on();
  auto program = std::make_shared<const OpenClProgram>(
      buildProgram(device, mesh_map::BVH_KERNELS, mesh_map::BVH_KERNEL_OPTIONS, cache));
  go_on();
  checkDevice(program, go_on);
  if (!program->from_cache) {
    go_on();
    keepProgram(*program, cache);
  }
  return program;
}

void OpenClSession::end(State state, std::shared_ptr<const OpenClProgram> program)
{
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    state_ = state;
    program_ = std::move(program);
  }
  ended_.notify_all();
}

void OpenClSession::log(LogLevel level, const std::string& line) const
{
  if (log_) {
    try {
      log_(level, line);
    } catch (...) {
      return;  // a log that is full is no reason to answer less
    }
  }
}

}  // namespace rviz_mesh_plugin
