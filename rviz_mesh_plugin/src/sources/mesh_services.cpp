#include "sources/mesh_services.h"

#include <algorithm>
#include <exception>
#include <map>
#include <mutex>
#include <optional>
#include <tuple>
#include <utility>

#include "sources/service_desk.h"
#include "threads/work_lanes.h"

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
       const ServiceNames& names, const Pauses& pauses)
      : desk_(std::make_shared<ServiceDesk>(inbox, loader, names)), pauses_(pauses)
  {
  }

  ~Work() { desk_->cancel(); }

  /// @param fetch is given the desk, and whether it asks again; returns whether that is all
  template <class Fetch>
  void add(const std::string& lane, const std::string& key, const Fetch& fetch)
  {
    std::shared_ptr<Question>& question = questions_[lane + "\n" + key];
    if (question && !question->isDue()) {
      return;
    }
    const auto asked = std::make_shared<Question>();
    const bool again = question != nullptr;
    asked->pause = again ? std::min(2 * question->pause, pauses_.greatest) : pauses_.first;
    lanes_.add(lane, [desk = desk_, fetch, asked, again]() {
      bool complete = false;
      try {
        complete = fetch(*desk, again);
      } catch (const Cancelled&) {
        return;
      } catch (const std::exception& error) {
        desk->log().want("services");
        desk->log().fail("services", "the services",
                         std::string("cannot be asked: ") + error.what());
      }
      asked->end(complete);
    });
    question = asked;
  }

  ServiceDesk& desk() { return *desk_; }

 private:
  using Clock = std::chrono::steady_clock;

  class Question
  {
   public:
    std::chrono::milliseconds pause{0};  ///< after it

    void end(bool complete)
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (!complete) {
        due_ = Clock::now() + pause;
      }
    }

    bool isDue() const
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      return due_ && Clock::now() >= *due_;
    }

   private:
    mutable std::mutex mutex_;
    std::optional<Clock::time_point> due_;  ///< nothing: it is being asked, or all has come
  };

  std::shared_ptr<ServiceDesk> desk_;
  const Pauses pauses_;
  std::map<std::string, std::shared_ptr<Question>> questions_;
  WorkLanes lanes_;
};

MeshServices::MeshServices(std::shared_ptr<MeshInbox> inbox, std::shared_ptr<MeshLoader> loader,
                           Pauses pauses)
    : inbox_(std::move(inbox)), loader_(std::move(loader)), pauses_(pauses)
{
}

MeshServices::MeshServices(std::shared_ptr<MeshInbox> inbox, std::shared_ptr<MeshLoader> loader)
    : MeshServices(std::move(inbox), std::move(loader), Pauses())
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
      work_ = std::make_unique<Work>(inbox_, loader_, names_, pauses_);
    }
    request(*work_, key);
  } catch (const std::exception& error) {  // no more threads or files
    failure_ = std::string("the services cannot be asked: ") + error.what();
  }
}

void MeshServices::requestMesh(const std::string& uuid)
{
  request(uuid, [](Work& work, const std::string& key) {
    work.add("mesh", key,
             [key](ServiceDesk& desk, bool again) { return desk.fetchMesh(key, again); });
  });
}

void MeshServices::requestColors(const std::string& uuid)
{
  if (!names_.colors.empty()) {
    request(uuid, [](Work& work, const std::string& key) {
      work.add("colors", key,
               [key](ServiceDesk& desk, bool again) { return desk.fetchColors(key, again); });
    });
  }
}

void MeshServices::requestMaterials(const std::string& uuid)
{
  if (!names_.materials.empty()) {
    request(uuid, [](Work& work, const std::string& key) {
      work.add("materials", key,
               [key](ServiceDesk& desk, bool again) { return desk.fetchMaterials(key, again); });
    });
  }
}

void MeshServices::requestCosts(const std::string& uuid)
{
  request(uuid, [](Work& work, const std::string& key) {
    work.add("layer names", key,
             [key](ServiceDesk& desk, bool again) { return desk.fetchLayerNames(key, again); });
  });
}

void MeshServices::requestLayer(const std::string& uuid, const std::string& type)
{
  request(uuid, [&](Work& work, const std::string&) {
    work.add("layers", uuid + "\n" + type, [uuid, type](ServiceDesk& desk, bool again) {
      return desk.fetchLayer(uuid, type, again);
    });
  });
}

void MeshServices::requestLabels(const std::string& uuid)
{
  request(uuid, [](Work& work, const std::string& key) {
    work.add("labels", key,
             [key](ServiceDesk& desk, bool again) { return desk.fetchLabels(key, again); });
  });
}

bool MeshServices::missesTextures(const std::string& uuid) const
{
  return work_ && work_->desk().missesTextures(uuid);
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
