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
  std::string text = what + " was not published: " + problem_;
  if (publisher_) {
    text = what + " was published on " + publisher_.getTopic();
    if (publisher_.getNumSubscribers() > 0) {
      ROS_INFO("%s", text.c_str());
      return text;
    }
    text += ", but nobody receives it: start a receiver, or change the property Topic of the tool";
  }
  ROS_WARN("%s", text.c_str());
  return text;
}

}  // namespace rviz_mesh_plugin
