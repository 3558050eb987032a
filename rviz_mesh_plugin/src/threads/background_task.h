#pragma once

#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "threads/ending_thread.h"

namespace rviz_mesh_plugin {

/// One task at a time on a thread of its own; nobody waits for it. Destroyed before the task has
/// ended, its outcome is dropped.
template <class Result>
class BackgroundTask
{
 public:
  struct Outcome
  {
    std::optional<Result> result;
    std::string error;  ///< where there is no result
  };

  /// @param work owns what it uses, and ends soon. @throw std::system_error without a thread
  void start(std::function<Result()> work)
  {
    auto shared = std::make_shared<Shared>();
    thread_ = std::make_unique<EndingThread>([shared, work = std::move(work)] {
      Outcome outcome;
      try {
        outcome.result = work();
      } catch (const std::exception& error) {
        outcome.error = error.what();
      }
      const std::lock_guard<std::mutex> lock(shared->mutex);
      shared->outcome = std::move(outcome);
    });
    shared_ = std::move(shared);
  }

  bool isRunning() const { return shared_ != nullptr; }

  /// Once it has ended, and then nothing again.
  std::optional<Outcome> take()
  {
    if (!shared_) {
      return std::nullopt;
    }
    std::unique_lock<std::mutex> lock(shared_->mutex);
    if (!shared_->outcome) {
      return std::nullopt;
    }
    std::optional<Outcome> outcome = std::move(shared_->outcome);
    lock.unlock();
    drop();
    return outcome;
  }

  void drop()
  {
    shared_.reset();
    thread_.reset();
  }

 private:
  struct Shared
  {
    std::mutex mutex;
    std::optional<Outcome> outcome;
  };
  std::shared_ptr<Shared> shared_;
  std::unique_ptr<EndingThread> thread_;
};

}  // namespace rviz_mesh_plugin
