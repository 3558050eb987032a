#include "navigation/navigation_server.h"

#include <roscpp/GetLoggers.h>
#include <std_srvs/Empty.h>

#include "base/status_lines.h"
#include "ros_client/service_call.h"

namespace rviz_mesh_plugin {
namespace {

/// With a process that takes a question: longer than that, it hangs.
constexpr std::chrono::seconds PROCESS_PATIENCE(3);
/// Between two such questions; what is not answered by then is given up.
constexpr std::chrono::seconds PROCESS_INTERVAL(6);
constexpr std::chrono::seconds CLOCK_PATIENCE(3);
constexpr std::chrono::seconds CLEAR_PATIENCE(60);

/// Asks what each node answers, of rospy and of roscpp.
ProcessState processOf(const std::string& node, const Cancellation& cancellation)
{
  try {
    const auto answer =
        ServiceCall(cancellation)
            .call(node + "/get_loggers", {ServiceCall::typeOf<roscpp::GetLoggers>()},
                  ros::serialization::serializeMessage(roscpp::GetLoggersRequest()));
    return answer ? ProcessState::ANSWERS : ProcessState::GONE;
  } catch (const ConnectionRefused&) {
    return ProcessState::GONE;
  } catch (const ConnectionLost&) {  // the master, or the network
    return ProcessState::UNREACHABLE;
  }
}

/// A sentence about what comes of it.
std::string clearBy(const std::string& service, const Cancellation& cancellation)
{
  try {
    const auto answer = ServiceCall(cancellation)
                            .call(service, {ServiceCall::typeOf<std_srvs::Empty>()},
                                  ros::serialization::serializeMessage(std_srvs::EmptyRequest()));
    if (answer && answer->refusal.empty()) {
      return "Cleared by " + service + ".";
    }
    return answer ? joined("Not cleared: ", service, " refuses it: ", shortened(answer->refusal))
                  : joined("Not cleared: there is no service ", service, " any more.");
  } catch (const Canceled&) {
    throw;
  } catch (const std::exception& error) {
    return joined("Not cleared: ", service, " cannot be called: ", error.what());
  }
}

}  // namespace

NavigationServer::NavigationServer(const std::string& name)
    : name_(name), watch_(name), connection_(name)
{
}

void NavigationServer::work(const ServerDirectory& directory, Time now)
{
  connection_.deliver(watch_);
  if (directory.asked()) {
    watch_.takeListing(directory.lists(name_), directory.problem());
  }
  lookAtClock(now);
  const bool was_there = watch_.phase(now) == ServerPhase::NOT_ANSWERING;
  askProcess(was_there || directory.lists(name_), now);
  if (auto cleared = clearing_.take()) {
    clear_report_ = cleared->result ? *cleared->result : "Not cleared: " + cleared->error;
  } else if (isClearing() && now - clearing_since_ > CLEAR_PATIENCE) {
    clearing_.drop();
    clear_report_ = "Not cleared: the service has not answered for a minute.";
  }
}

void NavigationServer::askProcess(bool may_be_there, Time now)
{
  if (!watch_.isSilent(now)) {
    if (process_asked_) {
      process_.drop();
      process_asked_.reset();
    }
    return;
  }
  if (const auto answer = process_.take()) {
    watch_.takeProcess(answer->result ? *answer->result : ProcessState::UNKNOWN);
  } else if (process_.isRunning() && now - *process_asked_ >= PROCESS_PATIENCE) {
    watch_.takeProcess(ProcessState::HANGS);
  }
  const bool due = !process_asked_ || now - *process_asked_ >= PROCESS_INTERVAL;
  if (may_be_there && due) {
    process_asked_ = now;
    process_.start(
        [name = name_](const Cancellation& cancellation) { return processOf(name, cancellation); });
  }
}

void NavigationServer::lookAtClock(Time now)
{
  const ros::Time time = ros::Time::isValid() ? ros::Time::now() : ros::Time();
  if (!ticked_ || time != ros_time_ || !ros::Time::isSimTime()) {
    ticked_ = now;
  }
  ros_time_ = time;
  time_stopped_ = now - *ticked_ >= CLOCK_PATIENCE;
  watch_.takeClock(time_stopped_);
}

/// That of move_base comes first: it begins nothing new then. What others have begun beside it
/// would drive on, and what has just begun may not be known to be busy yet: so the rest follows.
std::string NavigationServer::cancel()
{
  constexpr NavigationAction ALL[] = {NavigationAction::MOVE_BASE, NavigationAction::EXE_PATH,
                                      NavigationAction::RECOVERY, NavigationAction::GET_PATH};
  bool told = false;
  std::string missed;
  for (const NavigationAction action : ALL) {
    if (connection_.cancel(action)) {
      told = true;
    } else if (watch_.isBusy(action)) {
      missed += (missed.empty() ? "" : ", ") + std::string(nameOf(action));
    }
  }
  const char* const way_out = " Stop the robot by its own switch.";
  if (!missed.empty()) {
    return joined(told ? "Cancel was sent, but not for " : "Cancel was not sent for ", missed, ": ",
                  name_, " cannot be reached there.", way_out);
  }
  return told ? "Cancel was sent."
              : joined("Cancel was not sent: ", name_, " cannot be reached.", way_out);
}

bool NavigationServer::canCancel() const
{
  return watch_.isBusy() || connection_.hearsCancel();
}

void NavigationServer::clear(const std::vector<std::string>& services)
{
  if (services.empty()) {
    clear_report_ = joined("Not cleared: ", name_, " has no service clear_mesh or clear_costmaps.");
    return;
  }
  clear_report_.clear();
  clearing_since_ = std::chrono::steady_clock::now();
  clearing_.start([services](const Cancellation& cancellation) {
    std::string report;
    for (const std::string& service : services) {
      report += (report.empty() ? "" : " ") + clearBy(service, cancellation);
    }
    return report;
  });
}

std::string NavigationServer::clearReport(Time now) const
{
  if (!isClearing()) {
    return clear_report_;
  }
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(now - clearing_since_);
  return joined("Clearing, for ", seconds.count(), " s.");
}

}  // namespace rviz_mesh_plugin
