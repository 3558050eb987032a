#include "sources/face_parents_source.h"

#include <exception>
#include <mutex>
#include <utility>

#include <mesh_msgs/GetDerivedMesh.h>
#include <ros/console.h>
#include <ros/names.h>

#include "base/status_lines.h"
#include "ros_client/service_call.h"

namespace rviz_mesh_plugin {

/// What the thread that asks uses, too: the last mesh that was asked for.
struct FaceParentsSource::Known
{
  std::mutex mutex;
  std::string uuid;
  bool asking = false;
  bool answered = false;
  FaceParentsConstPtr parents;
};

FaceParentsSource::FaceParentsSource() : known_(std::make_shared<Known>()) {}

void FaceParentsSource::connect(const std::string& name_space)
{
  if (name_space != namespace_) {
    disconnect();
    known_ = std::make_shared<Known>();
    namespace_ = name_space;
  }
  connected_ = !name_space.empty();
}

void FaceParentsSource::disconnect()
{
  if (!connected_) {
    return;
  }
  connected_ = false;
  thread_.cancel();
  const auto before = known_;  // what is on its way arrives there
  known_ = std::make_shared<Known>();
  const std::lock_guard<std::mutex> lock(before->mutex);
  known_->uuid = before->uuid;
  known_->answered = before->answered;
  known_->parents = before->parents;
}

void FaceParentsSource::request(const std::string& uuid, std::size_t face_count)
{
  if (!connected_) {
    return;
  }
  const std::lock_guard<std::mutex> lock(known_->mutex);
  if (known_->uuid == uuid && (known_->asking || known_->answered)) {
    return;
  }
  // First: where there is no thread, nobody is asked. The answer waits for the lock.
  thread_.add([known = known_, uuid, face_count,
               service = ros::names::append(namespace_, "get_derived_mesh")](
                  const Cancellation& cancellation) {
    ask(*known, service, uuid, face_count, cancellation);
  });
  known_->uuid = uuid;
  known_->asking = true;
  known_->answered = false;
  known_->parents = nullptr;
}

void FaceParentsSource::ask(Known& known, const std::string& service, const std::string& uuid,
                            std::size_t face_count, const Cancellation& cancellation)
{
  FaceParentsConstPtr parents;
  bool answered = false;
  try {
    using mesh_msgs::GetDerivedMesh;
    GetDerivedMesh::Request request;
    request.uuid = uuid;
    const auto answer = ServiceCall(cancellation).callPatiently<GetDerivedMesh>(service, request);
    if (answer && answer->refusal.empty()) {
      auto response = answer->read<GetDerivedMesh::Response>();
      if (response.face_parents.empty() || response.face_parents.size() == face_count) {
        answered = true;
        if (!response.face_parents.empty()) {
          parents = std::make_shared<FaceParents>(std::move(response.face_parents));
        }
      } else {
        ROS_WARN("%s tells of %zu faces, the mesh has %zu", service.c_str(),
                 response.face_parents.size(), face_count);
      }
    } else if (answer) {
      ROS_DEBUG("%s refuses: %s", service.c_str(), shortened(answer->refusal).c_str());
    }
  } catch (const Canceled&) {
  } catch (const std::exception& error) {
    ROS_WARN("%s cannot be called: %s", service.c_str(), error.what());
  }
  const std::lock_guard<std::mutex> lock(known.mutex);
  if (known.uuid == uuid) {
    known.asking = false;
    known.answered = answered;
    known.parents = std::move(parents);
  }
}

FaceParentsConstPtr FaceParentsSource::parents(const std::string& uuid) const
{
  const std::lock_guard<std::mutex> lock(known_->mutex);
  return known_->uuid == uuid ? known_->parents : nullptr;
}

}  // namespace rviz_mesh_plugin
