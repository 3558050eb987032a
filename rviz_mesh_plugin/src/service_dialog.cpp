#include "rviz_mesh_plugin/service_dialog.h"

#include <ros/exceptions.h>

namespace rviz_mesh_plugin {

ServiceDialog::ServiceDialog(const ServiceNames& names, const Cancellation& cancellation,
                             ServiceLog& log)
    : names_(names), log_(log), asker_(cancellation, log)
{
}

std::vector<std::string> ServiceDialog::candidates(const std::string& service) const
{
  return serviceCandidates(service, names_);
}

bool ServiceDialog::findNames(const std::string& service, std::vector<std::string>& names)
{
  try {
    names = candidates(service);
    return true;
  } catch (const ros::InvalidNameException& error) {
    log_.fail(service, "'" + service + "'",
              std::string("is no name of a service: ") + error.what());
  }
  return false;
}

bool ServiceDialog::belongs(const std::string& service, const std::string& name,
                            const std::string& asked, std::string& given)
{
  if (given.empty()) {
    given = asked;
  }
  // "" and "mesh" mean the only one.
  if (asked.empty() || asked == "mesh" || given == asked) {
    return true;
  }
  log_.fail(
      service, name,
      "answers for the mesh '" + given + "', but '" + asked + "' is shown; it serves another map");
  return false;
}

bool ServiceDialog::finish(const std::string& service, const std::string& name, bool accepted,
                           const std::string& remark)
{
  if (accepted) {
    log_.answer(service, name, remark);
  } else {
    log_.fail(service, name, "answers with what cannot be shown, as the line on it says");
  }
  return accepted;
}

}  // namespace rviz_mesh_plugin
