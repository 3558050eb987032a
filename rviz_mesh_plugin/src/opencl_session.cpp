#include "rviz_mesh_plugin/opencl_session.h"

#include <mesh_map/bvh_device.h>

#include <map>
#include <stdexcept>
#include <utility>

#include "device_check.h"
#include "rviz_mesh_plugin/opencl_program.h"

namespace rviz_mesh_plugin {

namespace {

using Key = std::pair<std::string, std::string>;  // wish, folder of the cache

struct Registry
{
  std::mutex mutex;
  std::map<Key, std::weak_ptr<OpenClSession>> sessions;
  std::map<Key, std::string> refusals;  // of devices that did not start
};

/// Never destroyed: sessions may outlive any static object.
Registry& registry()
{
  static Registry& registry = *new Registry;
  return registry;
}

/// The session was destroyed while it started.
struct Stopped
{
};

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
  session.reset(new OpenClSession(wish, cache_folder, std::move(log)));
  const auto refusal = all.refusals.find(key);
  if (refusal != all.refusals.end()) {
    session->end(State::UNUSABLE, refusal->second);
    return session;
  }
  all.sessions[key] = session;
  try {
    session->thread_ = std::thread([raw = session.get()] { raw->run(); });
  } catch (const std::system_error& error) {
    session->end(State::UNUSABLE, nativeInstead(error.what()));
    session->log(LogLevel::WARNING, session->text());
  }
  return session;
}

OpenClSession::OpenClSession(std::string wish, const std::string& cache_folder, LogFunction log)
    : wish_(std::move(wish)), cache_folder_(cache_folder), log_(std::move(log))
{
}

OpenClSession::~OpenClSession()
{
  stop_ = true;
  if (thread_.joinable()) {
    thread_.join();
  }
}

bool OpenClSession::wait() const
{
  std::unique_lock<std::mutex> lock(mutex_);
  ended_.wait(lock, [this] { return state_ != State::STARTING; });
  return state_ == State::READY;
}

std::string OpenClSession::text() const
{
  const std::lock_guard<std::mutex> lock(mutex_);
  return text_;
}

std::shared_ptr<const OpenClProgram> OpenClSession::program() const
{
  const std::lock_guard<std::mutex> lock(mutex_);
  return program_;
}

void OpenClSession::fail(const std::string& why)
{
  if (state_.exchange(State::UNUSABLE) != State::UNUSABLE) {
    end(State::UNUSABLE, nativeInstead(why));
    log(LogLevel::WARNING, text());
  }
}

void OpenClSession::run()
{
  std::string why;
  try {
    const auto program = start();
    const std::string text = "OpenCL: batches of queries are answered by " + program->info.text() +
                             ", program " + (program->from_cache ? "from the cache" : "compiled");
    log(LogLevel::INFO, text);
    end(State::READY, text, program);
    return;
  } catch (const Stopped&) {
    end(State::UNUSABLE, "stopped");
    return;
  } catch (const cl::BuildError& error) {
    why = describe(error) + ": " + excerpt(error);
  } catch (const cl::Error& error) {
    why = describe(error);
  } catch (const std::exception& error) {
    why = error.what();
  }
  const std::string text = nativeInstead(why);
  {
    Registry& all = registry();
    const std::lock_guard<std::mutex> lock(all.mutex);
    all.refusals[{wish_, cache_folder_}] = text;
  }
  log(LogLevel::WARNING, text);
  end(State::UNUSABLE, text);
}

std::shared_ptr<const OpenClProgram> OpenClSession::start() const
{
  const ProgramCache cache(cache_folder_);
  const std::vector<cl::Device> devices = listDevices();
  const cl::Device& device = devices.at(choose(devices, wish_));
  goOn();
  auto program = std::make_shared<const OpenClProgram>(
      buildProgram(device, mesh_map::BVH_KERNELS, mesh_map::BVH_KERNEL_OPTIONS, cache));
  goOn();
  checkDevice(program, [this] { goOn(); });
  if (!program->from_cache) {
    goOn();
    keepProgram(*program, cache);
  }
  return program;
}

void OpenClSession::end(State state, const std::string& text,
                        std::shared_ptr<const OpenClProgram> program)
{
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    text_ = text;
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

void OpenClSession::goOn() const
{
  if (stop_) {
    throw Stopped();
  }
}

}  // namespace rviz_mesh_plugin
