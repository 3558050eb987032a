#include "properties/published_topic.h"

#include <exception>

#include <ros/console.h>
#include <rviz/properties/string_property.h>

namespace rviz_mesh_plugin {

PublishedTopic::PublishedTopic(rviz::Property* parent, const char* topic, const char* description,
                               const Advertise& advertise)
    : property_(new rviz::StringProperty("Topic", topic, description, parent)),
      advertise_(advertise)
{
}

void PublishedTopic::connect()
{
  QObject::connect(property_, &rviz::Property::changed, &guard_, [this] { update(); });
  update();
}

void PublishedTopic::update()
{
  try {
    publisher_.shutdown();
    publisher_ = ros::Publisher();
    const std::string topic = property_->getStdString();
    problem_ = "there is no topic: set the property Topic of the tool";
    if (node_.resolveName(topic).size() > 1 && !topic.empty()) {  // "/" is no topic
      publisher_ = advertise_(node_, topic);
      problem_ =
          "'" + topic + "' is a topic of another type: change the property Topic of the tool";
    }
    if (publisher_) {
      problem_.clear();
    }
  } catch (const std::exception& error) {  // above all ros::InvalidNameException
    problem_ = std::string(error.what()) + ": change the property Topic of the tool";
  }
}

std::string PublishedTopic::report(const std::string& what) const
{
  if (!publisher_) {
    ROS_WARN("%s was not published: %s", what.c_str(), problem_.c_str());
    return what + " was not published: " + problem_;
  }
  const std::string topic = publisher_.getTopic();
  if (publisher_.getNumSubscribers() == 0) {
    ROS_WARN("%s was published on %s, but nobody receives it", what.c_str(), topic.c_str());
    return what + " was published on " + topic +
           ", but nobody receives it: start a receiver, or change the property Topic of the tool";
  }
  ROS_INFO("%s was published on %s", what.c_str(), topic.c_str());
  return what + " was published on " + topic;
}

}  // namespace rviz_mesh_plugin
