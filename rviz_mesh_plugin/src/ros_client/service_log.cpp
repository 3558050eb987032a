#include "ros_client/service_log.h"

#include <sstream>

#include <QString>

namespace rviz_mesh_plugin {
namespace {

using State = ServiceReport::State;
using Entry = ServiceLog::Entry;

/// Answers shorter than this come faster than anybody reads.
constexpr std::size_t WORTH_TELLING_BYTES = 1000000;

std::string megabytes(std::size_t bytes)
{
  return QString::number(double(bytes) / 1e6, 'f', 1).toStdString();
}

State stateOf(const Entry& entry)
{
  return entry.busy ? entry.state : entry.failed > 0 ? State::FAILED : State::ANSWERED;
}

std::string sentence(const Entry& entry)
{
  std::ostringstream text;
  if (entry.busy && entry.state == State::SEARCHING) {
    text << "waiting for the service " << entry.service << ": " << entry.reason
         << "; start what serves the map, or correct the name";
  } else if (entry.busy && entry.state == State::FAILED) {
    text << entry.name << " cannot be used: " << entry.reason << "; it is tried again each second";
  } else if (entry.busy) {
    const auto seconds =
        std::chrono::duration_cast<std::chrono::seconds>(ServiceLog::Clock::now() - entry.since)
            .count();
    text << entry.name << " was asked " << seconds << " s ago";
    if (entry.of >= WORTH_TELLING_BYTES) {
      text << ", " << megabytes(entry.bytes) << " of " << megabytes(entry.of) << " MB are here";
    }
  } else if (entry.failed == 0) {
    text << entry.name << " has answered" << (entry.remark.empty() ? "" : ": ") << entry.remark;
  } else {
    text << entry.name << " " << entry.failure << "; it is asked again from time to time";
  }
  if (!entry.items.empty()) {
    text << " (" << entry.answered << " of " << entry.wanted << " " << entry.items;
    if (entry.failed > 0) {
      text << ", " << entry.failed << " refused";
    }
    text << ")";
  }
  return text.str();
}

}  // namespace

OptionalStatus ServiceReport::status(State least) const
{
  if (text.empty()) {
    return std::nullopt;
  }
  return worst >= least ? StatusLine::warn(text) : StatusLine::ok(text);
}

void ServiceLog::want(const std::string& service, const std::string& items, bool again)
{
  note(service, [&](Entry& entry) {
    entry.items = items;
    if (again && entry.failed > 0) {
      --entry.failed;
    } else if (again && entry.answered > 0) {
      --entry.answered;
    } else {
      ++entry.wanted;
    }
  });
}

void ServiceLog::fail(const std::string& service, const std::string& name,
                      const std::string& reason)
{
  note(service, [&](Entry& entry) {
    entry.name = name;
    entry.busy = false;
    if (entry.failed++ == 0) {
      entry.failure = shortened(reason);
    }
  });
}

ServiceReport ServiceLog::report() const
{
  const std::lock_guard<std::mutex> lock(mutex_);
  ServiceReport report;
  for (const State state : {State::FAILED, State::SEARCHING, State::WAITING, State::ANSWERED}) {
    for (const Entry& entry : entries_) {
      if (entry.wanted > 0 && stateOf(entry) == state) {
        report.worst = std::max(report.worst, state);
        report.text += (report.text.empty() ? "" : "; ") + sentence(entry);
      }
    }
  }
  return report;
}

}  // namespace rviz_mesh_plugin
