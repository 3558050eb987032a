#include "rviz_mesh_plugin/service_asker.h"

#include <exception>

namespace rviz_mesh_plugin {

ServiceAsker::ServiceAsker(const Cancellation& cancellation, ServiceLog& log)
    : cancellation_(cancellation), log_(log)
{
}

ServiceAsker::Result ServiceAsker::tryOnce(const std::string& service,
                                           const std::vector<std::string>& names,
                                           const std::vector<ServiceType>& types,
                                           const ros::SerializedMessage& request)
{
  Result refused;
  std::string lost, objector, objection;
  const auto refuse = [&](const std::string& name, const std::string& reason) {
    if (refused.outcome == Outcome::NOT_YET) {
      refused.outcome = Outcome::REFUSED;
      refused.name = name;
      refused.answer.refusal = reason;
    }
  };
  for (const std::string& name : names) {
    try {
      const auto address = lookUpService(name, cancellation_);
      if (!address) {
        continue;
      }
      log_.ask(service, name);
      Result result;
      result.name = name;
      result.answer =
          callService(name, *address, types, request, cancellation_,
                      [&](std::size_t bytes, std::size_t of) { log_.receive(service, bytes, of); });
      if (result.answer.refusal.empty()) {
        result.outcome = Outcome::ANSWERED;
        return result;
      }
      refuse(name, result.answer.refusal);
    } catch (const Cancelled&) {
      throw;
    } catch (const ConnectionLost& error) {
      lost = name + " does not answer: " + error.what();
    } catch (const WrongService& error) {
      objector = name;
      objection = error.what();
    } catch (const std::exception& error) {  // out of memory, or of files
      refuse(name, std::string("its answer cannot be read: ") + error.what());
    }
  }
  if (refused.outcome == Outcome::NOT_YET) {
    if (objection.empty()) {
      log_.search(service, names, lost);
    } else {
      log_.object(service, objector, objection);
    }
  }
  return refused;
}

ServiceAsker::Result ServiceAsker::ask(const std::string& service,
                                       const std::vector<std::string>& names,
                                       const std::vector<ServiceType>& types,
                                       const ros::SerializedMessage& request)
{
  while (true) {
    Result result = tryOnce(service, names, types, request);
    if (result.outcome != Outcome::NOT_YET) {
      return result;
    }
    pause();
  }
}

void ServiceAsker::pause() const
{
  cancellation_.wait(-1, 0, 1000);
}

}  // namespace rviz_mesh_plugin
