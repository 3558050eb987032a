#include "sources/service_log.h"

#include <algorithm>
#include <iomanip>
#include <sstream>

namespace rviz_mesh_plugin {
namespace {

using State = ServiceReport::State;

/// Answers shorter than this come faster than anybody reads.
constexpr std::size_t WORTH_TELLING_BYTES = 1000000;

std::string megabytes(std::size_t bytes)
{
  std::ostringstream stream;
  stream << std::fixed << std::setprecision(1) << double(bytes) / 1e6;
  return stream.str();
}

std::string join(const std::vector<std::string>& names)
{
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) {
    text += (i == 0 ? "" : i + 1 == names.size() ? " and " : ", ") + names[i];
  }
  return text;
}

}  // namespace

std::string shortened(std::string text)
{
  if (text.size() > 300) {
    text = text.substr(0, 297) + "...";
  }
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < 32 || c == 127; }, ' ');
  return text;
}

State ServiceReport::worst() const
{
  State worst = State::ANSWERED;
  for (const Line& line : lines) {
    worst = std::max(worst, line.state);
  }
  return worst;
}

std::string ServiceReport::text() const
{
  std::string all;
  for (const State state : {State::FAILED, State::SEARCHING, State::WAITING, State::ANSWERED}) {
    for (const Line& line : lines) {
      if (line.state == state) {
        all += (all.empty() ? "" : "; ") + line.text;
      }
    }
  }
  return all;
}

ServiceLog::Entry& ServiceLog::entry(const std::string& service)
{
  const auto found = std::find_if(entries_.begin(), entries_.end(),
                                  [&](const Entry& one) { return one.service == service; });
  if (found != entries_.end()) {
    return *found;
  }
  entries_.emplace_back();
  entries_.back().service = entries_.back().name = service;
  entries_.back().since = Clock::now();
  return entries_.back();
}

void ServiceLog::want(const std::string& service, const std::string& items, bool again)
{
  const std::lock_guard<std::mutex> lock(mutex_);
  Entry& entry = this->entry(service);
  entry.items = items;
  if (again && entry.failed > 0) {
    --entry.failed;
  } else if (again && entry.answered > 0) {
    --entry.answered;
  } else {
    ++entry.wanted;
  }
}

void ServiceLog::search(const std::string& service, const std::vector<std::string>& tried,
                        const std::string& reason)
{
  const std::lock_guard<std::mutex> lock(mutex_);
  Entry& entry = this->entry(service);
  entry.name = service;
  entry.state = State::SEARCHING;
  entry.busy = true;
  entry.reason = shortened(reason.empty() ? "there is no " + join(tried) : reason);
}

void ServiceLog::ask(const std::string& service, const std::string& name)
{
  const std::lock_guard<std::mutex> lock(mutex_);
  Entry& entry = this->entry(service);
  entry.name = name;
  entry.state = State::WAITING;
  entry.busy = true;
  entry.bytes = entry.of = 0;
  entry.since = Clock::now();
}

void ServiceLog::receive(const std::string& service, std::size_t bytes, std::size_t of)
{
  const std::lock_guard<std::mutex> lock(mutex_);
  Entry& entry = this->entry(service);
  entry.bytes = bytes;
  entry.of = of;
}

void ServiceLog::object(const std::string& service, const std::string& name,
                        const std::string& reason)
{
  const std::lock_guard<std::mutex> lock(mutex_);
  Entry& entry = this->entry(service);
  entry.name = name;
  entry.state = State::FAILED;
  entry.busy = true;
  entry.reason = shortened(reason);
}

void ServiceLog::answer(const std::string& service, const std::string& name,
                        const std::string& remark)
{
  const std::lock_guard<std::mutex> lock(mutex_);
  Entry& entry = this->entry(service);
  entry.name = name;
  entry.remark = shortened(remark);
  entry.busy = false;
  ++entry.answered;
}

void ServiceLog::fail(const std::string& service, const std::string& name,
                      const std::string& reason)
{
  const std::lock_guard<std::mutex> lock(mutex_);
  Entry& entry = this->entry(service);
  entry.name = name;
  entry.busy = false;
  if (entry.failed++ == 0) {
    entry.failure = shortened(reason);
  }
}

ServiceReport::Line ServiceLog::line(const Entry& entry)
{
  ServiceReport::Line line;
  line.service = entry.name;
  line.state = entry.busy ? entry.state : entry.failed > 0 ? State::FAILED : State::ANSWERED;
  std::ostringstream text;
  if (entry.busy && entry.state == State::SEARCHING) {
    text << "waiting for the service " << entry.service << ": " << entry.reason
         << "; start what serves the map, or correct the name";
  } else if (entry.busy && entry.state == State::FAILED) {
    text << entry.name << " cannot be used: " << entry.reason << "; it is tried again each second";
  } else if (entry.busy) {
    const auto seconds =
        std::chrono::duration_cast<std::chrono::seconds>(Clock::now() - entry.since).count();
    text << entry.name << " was asked " << seconds << " s ago";
    if (entry.of >= WORTH_TELLING_BYTES) {
      text << ", " << megabytes(entry.bytes) << " of " << megabytes(entry.of) << " MB are here";
    }
  } else if (entry.failed == 0) {
    text << entry.name << " has answered";
    text << (entry.remark.empty() ? "" : ": ") << entry.remark;
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
  line.text = text.str();
  return line;
}

ServiceReport ServiceLog::report() const
{
  const std::lock_guard<std::mutex> lock(mutex_);
  ServiceReport report;
  for (const Entry& entry : entries_) {
    if (entry.wanted > 0) {
      report.lines.push_back(line(entry));
    }
  }
  return report;
}

}  // namespace rviz_mesh_plugin
