#pragma once

#include <functional>
#include <string>

#include <QObject>

#include <ros/node_handle.h>
#include <ros/publisher.h>

namespace rviz {
class Property;
class StringProperty;
}  // namespace rviz

namespace rviz_mesh_plugin {

/// A topic to publish on, by a property "Topic" of a tool: not latched, and of a queue of one
/// message. A name that is no topic, or one of another type, is told, and nothing is thrown.
class PublishedTopic
{
 public:
  using Advertise = std::function<ros::Publisher(ros::NodeHandle&, const std::string& topic)>;

  /// @param parent outlives this
  PublishedTopic(rviz::Property* parent, const char* topic, const char* description,
                 const Advertise& advertise);

  template <class Message>
  static ros::Publisher advertise(ros::NodeHandle& node, const std::string& topic)
  {
    return node.advertise<Message>(topic, 1);
  }

  /// From now on there is a publisher.
  void connect();

  /// @return what has become of the message, as "<what> was published on …"
  template <class Message>
  std::string publish(const std::string& what, const Message& message)
  {
    if (publisher_) {
      publisher_.publish(message);
    }
    return report(what);
  }

  /// That is published on, resolved; empty where nothing can be published.
  std::string name() const { return publisher_ ? publisher_.getTopic() : std::string(); }

  /// Why nothing can be published; else empty.
  const std::string& problem() const { return problem_; }

 private:
  void update();
  std::string report(const std::string& what) const;

  rviz::StringProperty* property_;
  Advertise advertise_;
  ros::NodeHandle node_;
  ros::Publisher publisher_;
  std::string problem_ = "it is not connected yet";
  QObject guard_;  ///< ends the connection to the property
};

}  // namespace rviz_mesh_plugin
