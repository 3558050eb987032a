#pragma once

#include <chrono>
#include <cstddef>
#include <mutex>
#include <string>
#include <vector>

namespace rviz_mesh_plugin {

/// A reason of somebody else's, short and on one line.
std::string shortened(std::string text);

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
  struct Line
  {
    std::string service;  ///< its name as found, else as looked for
    State state = State::SEARCHING;
    std::string text;  ///< a sentence
  };
  std::vector<Line> lines;  ///< one per service that was asked, in order of the first request

  /// The last in the order of the enumeration; ANSWERED without lines.
  State worst() const;

  /// All sentences, the worst first; empty without lines.
  std::string text() const;
};

/// Keeps the report. Thread safe. A service is named as it is looked for, "get_texture".
class ServiceLog
{
 public:
  /// One more thing is wanted of a service.
  /// @param items what these are, "textures"; empty where there is one thing only
  /// @param again it was refused before, which does not count any more
  void want(const std::string& service, const std::string& items = std::string(),
            bool again = false);

  /// @param tried the names it is looked for by
  /// @param reason why it cannot be asked
  void search(const std::string& service, const std::vector<std::string>& tried,
              const std::string& reason);
  void ask(const std::string& service, const std::string& name);
  void receive(const std::string& service, std::size_t bytes, std::size_t of);

  /// It cannot be used as it is, but is asked again.
  void object(const std::string& service, const std::string& name, const std::string& reason);

  /// @param remark more about the answer, to be told; may be empty
  void answer(const std::string& service, const std::string& name,
              const std::string& remark = std::string());

  /// @param reason goes on after the name: "refuses: …"
  void fail(const std::string& service, const std::string& name, const std::string& reason);

  ServiceReport report() const;

 private:
  using Clock = std::chrono::steady_clock;
  struct Entry
  {
    std::string service;
    std::string name;
    std::string items;
    std::string reason;  ///< of searching or objecting
    std::string remark;
    std::string failure;  ///< the first
    ServiceReport::State state = ServiceReport::State::SEARCHING;
    bool busy = true;
    std::size_t wanted = 0;
    std::size_t answered = 0;
    std::size_t failed = 0;
    std::size_t bytes = 0;
    std::size_t of = 0;
    Clock::time_point since;
  };

  Entry& entry(const std::string& service);
  static ServiceReport::Line line(const Entry& entry);

  mutable std::mutex mutex_;
  std::vector<Entry> entries_;
};

}  // namespace rviz_mesh_plugin
