#pragma once

#include <atomic>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <string>

#include "spatial/program_cache.h"
#include "threads/work_thread.h"

namespace rviz_mesh_plugin {

struct OpenClProgram;

enum class LogLevel
{
  INFO,
  WARNING
};

/// Called from any thread, also after the object that it was given to has gone (devices are
/// shared): it refers to nothing that may go. What it throws is swallowed.
using LogFunction = std::function<void(LogLevel level, const std::string& line)>;

/// A device that starts in a thread of its own: it is found, its kernels are loaded or compiled,
/// and their answers about a small mesh are compared with the native ones. One log line tells which
/// device it is, or one warning why there is none.
class OpenClSession
{
 public:
  enum class State
  {
    STARTING,
    READY,
    UNUSABLE  ///< it did not start, or has failed since
  };

  /// The device of a wish (see deviceWish()) in this process, which all users share. One that does
  /// not start is not asked again; after one that fails later, the next call here starts anew.
  static std::shared_ptr<OpenClSession> shared(const std::string& wish,
                                               const std::string& cache_folder, LogFunction log);

  OpenClSession(const OpenClSession&) = delete;
  OpenClSession& operator=(const OpenClSession&) = delete;

  State state() const { return state_; }

  /// Waits until the start has ended, and returns whether the device is ready.
  bool wait() const;

  /// Null unless it is ready.
  std::shared_ptr<const OpenClProgram> program() const;

  /// Gives the device up: a warning the first time.
  void fail(const std::string& why);

  /// A warning about something else.
  void warn(const std::string& line) const { log(LogLevel::WARNING, line); }

 private:
  OpenClSession(std::string wish, const std::string& cache_folder, LogFunction log);

  void run(const Cancellation& cancellation);
  std::shared_ptr<const OpenClProgram> start(const Cancellation& cancellation) const;
  void end(State state, std::shared_ptr<const OpenClProgram> program = nullptr);
  void log(LogLevel level, const std::string& line) const;

  const std::string wish_, cache_folder_;
  const LogFunction log_;
  std::atomic<State> state_{State::STARTING};
  mutable std::mutex mutex_;  // of those below
  mutable std::condition_variable ended_;
  std::shared_ptr<const OpenClProgram> program_;
  WorkThread thread_{"OpenCL start"};
};

}  // namespace rviz_mesh_plugin
