#pragma once

#include <chrono>
#include <exception>
#include <functional>
#include <future>
#include <memory>
#include <new>
#include <optional>
#include <string>
#include <utility>

#include "threads/work_thread.h"

namespace rviz_mesh_plugin {

/// One task at a time on a thread of its own, and what comes of it; nobody waits for it. To be used
/// by one thread.
template <class Result>
class BackgroundTask
{
 public:
  struct Outcome
  {
    std::optional<Result> result;
    std::string error;  ///< where there is no result
  };

  /// As for WorkThread.
  explicit BackgroundTask(std::string name,
                          std::optional<std::chrono::milliseconds> patience = std::nullopt)
      : thread_(std::move(name), patience)
  {
  }

  /// Drops the one before.
  /// @param work owns what it uses, and ends soon once it is canceled
  /// @throw std::system_error without a thread
  void start(std::function<Result(const Cancellation& cancellation)> work)
  {
    if (isRunning() && !isReady()) {
      drop();
    }
    using Task = std::packaged_task<Result(const Cancellation&)>;
    const auto task = std::make_shared<Task>(std::move(work));
    thread_.add([task](const Cancellation& cancellation) { (*task)(cancellation); });
    result_ = task->get_future();
  }

  /// Until it has ended and its outcome has been taken.
  bool isRunning() const { return result_.valid(); }
  bool isReady() const
  {
    return isRunning() && result_.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
  }

  /// Once it has ended, and then nothing again.
  std::optional<Outcome> take()
  {
    if (!isReady()) {
      return std::nullopt;
    }
    Outcome outcome;
    try {
      outcome.result = result_.get();
    } catch (const std::bad_alloc&) {
      outcome.error = "there is not enough memory";
    } catch (const std::exception& error) {
      outcome.error = error.what();
    }
    return outcome;
  }

  /// Cancels it; its outcome is lost.
  void drop()
  {
    thread_.cancel();
    result_ = {};
  }

 private:
  WorkThread thread_;
  std::future<Result> result_;
};

}  // namespace rviz_mesh_plugin
