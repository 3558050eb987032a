#include "rviz_mesh_plugin/mesh_services.h"

#include <exception>
#include <set>
#include <tuple>
#include <utility>

#include "rviz_mesh_plugin/service_desk.h"
#include "rviz_mesh_plugin/work_lanes.h"

namespace rviz_mesh_plugin {
namespace {

auto tied(const ServiceNames& n)
{
  return std::tie(n.colors, n.materials, n.texture, n.geometry_topic, n.service_namespace);
}

}  // namespace

/// All that is asked between two calls of cancel().
class MeshServices::Work
{
 public:
  Work(const std::shared_ptr<MeshInbox>& inbox, const std::shared_ptr<MeshLoader>& loader,
       const ServiceNames& names)
      : desk_(std::make_shared<ServiceDesk>(inbox, loader, names))
  {
  }

  ~Work() { desk_->cancel(); }

  /// @param fetch is given the desk
  template <class Fetch>
  void add(const std::string& lane, const std::string& key, const Fetch& fetch)
  {
    if (!asked_.insert(lane + "\n" + key).second) {
      return;
    }
    lanes_.add(lane, [desk = desk_, fetch]() {
      try {
        fetch(*desk);
      } catch (const Cancelled&) {
      } catch (const std::exception& error) {
        desk->log().want("services");
        desk->log().fail("services", "the services",
                         std::string("cannot be asked: ") + error.what());
      }
    });
  }

  ServiceDesk& desk() { return *desk_; }

 private:
  std::shared_ptr<ServiceDesk> desk_;
  std::set<std::string> asked_;
  WorkLanes lanes_;
};

MeshServices::MeshServices(std::shared_ptr<MeshInbox> inbox, std::shared_ptr<MeshLoader> loader)
    : inbox_(std::move(inbox)), loader_(std::move(loader))
{
}

MeshServices::~MeshServices() = default;

void MeshServices::setNames(const ServiceNames& names)
{
  if (tied(names) != tied(names_)) {
    cancel();
    names_ = names;
  }
}

void MeshServices::cancel()
{
  work_.reset();
  failure_.clear();
}

template <class Request>
void MeshServices::request(const std::string& key, const Request& request)
{
  try {
    if (!work_) {
      work_ = std::make_unique<Work>(inbox_, loader_, names_);
    }
    request(*work_, key);
  } catch (const std::exception& error) {  // no more threads or files
    failure_ = std::string("the services cannot be asked: ") + error.what();
  }
}

void MeshServices::requestMesh(const std::string& uuid)
{
  request(uuid, [](Work& work, const std::string& key) {
    work.add("mesh", key, [key](ServiceDesk& desk) { desk.fetchMesh(key); });
  });
}

void MeshServices::requestColors(const std::string& uuid)
{
  if (!names_.colors.empty()) {
    request(uuid, [](Work& work, const std::string& key) {
      work.add("colors", key, [key](ServiceDesk& desk) { desk.fetchColors(key); });
    });
  }
}

void MeshServices::requestMaterials(const std::string& uuid)
{
  if (!names_.materials.empty()) {
    request(uuid, [](Work& work, const std::string& key) {
      work.add("materials", key, [key](ServiceDesk& desk) { desk.fetchMaterials(key); });
    });
  }
}

void MeshServices::requestCosts(const std::string& uuid)
{
  request(uuid, [](Work& work, const std::string& key) {
    work.add("layer names", key, [key](ServiceDesk& desk) { desk.fetchLayerNames(key); });
  });
}

void MeshServices::requestLayer(const std::string& uuid, const std::string& type)
{
  request(uuid, [&](Work& work, const std::string&) {
    work.add("layers", uuid + "\n" + type,
             [uuid, type](ServiceDesk& desk) { desk.fetchLayer(uuid, type); });
  });
}

void MeshServices::requestLabels(const std::string& uuid)
{
  request(uuid, [](Work& work, const std::string& key) {
    work.add("labels", key, [key](ServiceDesk& desk) { desk.fetchLabels(key); });
  });
}

std::vector<std::string> MeshServices::layers(const std::string& uuid) const
{
  return work_ ? work_->desk().layers(uuid) : std::vector<std::string>();
}

MeshServices::Report MeshServices::report() const
{
  Report report;
  if (work_) {
    report = work_->desk().log().report();
  }
  if (!failure_.empty()) {
    report.lines.push_back({"services", Report::State::FAILED, failure_});
  }
  return report;
}

}  // namespace rviz_mesh_plugin
