#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <mutex>
#include <string>
#include <vector>

#include "base/status_lines.h"

namespace rviz_mesh_plugin {

/// What has become of what services were asked, for a status line.
struct ServiceReport
{
  enum class State
  {
    ANSWERED,
    WAITING,    ///< asked
    SEARCHING,  ///< no service of that name answers
    FAILED
  };
  State worst = State::ANSWERED;  ///< the last in the order of the enumeration
  std::string text;  ///< a sentence for each service, the worst first; empty: none was asked

  /// A warning from this state on; nothing where none was asked.
  OptionalStatus status(State least) const;
};

/// Keeps the report, of services in order of the first request. Thread safe.
class ServiceLog
{
 public:
  using Clock = std::chrono::steady_clock;
  using State = ServiceReport::State;

  struct Entry
  {
    std::string service;  ///< as it is looked for, "get_texture"
    std::string name;     ///< as found, else as looked for
    std::string items;    ///< what is wanted of it; empty where that is one thing only
    std::string reason;   ///< why it is searched for, or cannot be used as it is
    std::string remark;   ///< more about the answer
    std::string failure;  ///< the first
    State state = State::SEARCHING;
    bool busy = true;
    std::size_t wanted = 0;
    std::size_t answered = 0;
    std::size_t failed = 0;
    std::size_t bytes = 0;
    std::size_t of = 0;
    Clock::time_point since = Clock::now();
  };

  /// @param change is given the entry of the service
  template <class Change>
  void note(const std::string& service, const Change& change)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    auto entry = std::find_if(entries_.begin(), entries_.end(),
                              [&](const Entry& one) { return one.service == service; });
    if (entry == entries_.end()) {
      entry = entries_.emplace(entry);
      entry->service = entry->name = service;
    }
    change(*entry);
  }

  /// One more thing is wanted of a service.
  /// @param items what these are, "textures"; empty where there is one thing only
  /// @param again it was asked before; that it was refused then does not count any more
  void want(const std::string& service, const std::string& items, bool again);

  /// @param reason goes on after the name: "refuses: …"
  void fail(const std::string& service, const std::string& name, const std::string& reason);

  ServiceReport report() const;

 private:
  mutable std::mutex mutex_;
  std::vector<Entry> entries_;
};

}  // namespace rviz_mesh_plugin
