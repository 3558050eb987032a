#pragma once

#include <array>
#include <memory>
#include <string>

#include <ros/node_handle.h>

#include "incoming/mesh_inbox.h"
#include "incoming/mesh_loader.h"
#include "sources/mesh_services.h"
#include "sources/mesh_topics.h"

namespace rviz_mesh_plugin {

class MeshProperties;
class MeshStore;

/// Where the data of a mesh display come from: its subscriptions and services,
/// and what converts what they bring.
class MeshFeed
{
 public:
  enum Kind
  {
    GEOMETRY,
    COSTS,
    FACE_COSTS,
    UPDATES,
    COLORS,
    MATERIALS,
    TEXTURES,
    LABELS,
    KINDS
  };

  MeshFeed();
  ~MeshFeed();

  /// Subscribes to the topics that the properties name; what came from a topic (or service) that is
  /// no longer named is forgotten, in the store too, and nothing else.
  /// @return whether anything was forgotten
  bool connect(ros::NodeHandle& node_handle, const MeshProperties& properties, MeshStore& store);

  /// Unsubscribes and gives up what services are asked; nothing is forgotten.
  void disconnect();

  /// Unsubscribes and forgets what has not been taken yet.
  void clear();

  MeshInbox& inbox() { return *inbox_; }
  MeshLoader& loader() { return *loader_; }
  MeshServices& services() { return *services_; }
  const MeshServices& services() const { return *services_; }

  const std::string& topic(Kind kind) const { return topics_[kind].name; }
  /// As others know it; empty where it is not subscribed to.
  const std::string& resolvedTopic(Kind kind) const { return topics_[kind].resolved; }
  /// Of the messages of a topic.
  static const char* type(Kind kind);
  /// Why the topic could not be subscribed to; else empty.
  const std::string& error(Kind kind) const { return topics_[kind].error; }

 private:
  struct Topic
  {
    std::string name;
    std::string service;  ///< asked for what no topic brings
    std::string error;
    std::string resolved;
    bool subscribed = false;
  };

  void forget(Kind kind, MeshStore& store);

  std::shared_ptr<MeshInbox> inbox_;
  std::shared_ptr<MeshLoader> loader_;
  std::unique_ptr<MeshServices> services_;
  MeshTopics subscriptions_;
  std::array<Topic, KINDS> topics_;
};

}  // namespace rviz_mesh_plugin
