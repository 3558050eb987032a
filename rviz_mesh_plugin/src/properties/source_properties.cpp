#include "properties/source_properties.h"

#include <initializer_list>

#include <mesh_msgs/MeshFaceCluster.h>
#include <mesh_msgs/MeshGeometryStamped.h>
#include <mesh_msgs/MeshMaterialsStamped.h>
#include <mesh_msgs/MeshTexture.h>
#include <mesh_msgs/MeshVertexColorsStamped.h>
#include <ros/message_traits.h>
#include <rviz/properties/ros_topic_property.h>
#include <rviz/properties/string_property.h>

#include "properties/cost_properties.h"

namespace rviz_mesh_plugin {
namespace {

template <class Message>
rviz::RosTopicProperty* makeTopic(const char* name, const char* description, rviz::Property* parent,
                                  QObject* receiver)
{
  return new rviz::RosTopicProperty(name, "",
                                    QString::fromLatin1(ros::message_traits::datatype<Message>()),
                                    description, parent, SIGNAL(changed()), receiver);
}

rviz::StringProperty* makeService(const char* name, const char* service, const char* of_what,
                                  rviz::Property* parent, QObject* receiver)
{
  return new rviz::StringProperty(
      name, service,
      QString("Asked for %1 that no topic brings. A name without a slash in front is looked for "
              "beside the geometry topic, in the namespaces above it and in that of RViz.")
          .arg(of_what),
      parent, SIGNAL(changed()), receiver);
}

}  // namespace

void SourceProperties::addGeometry(rviz::Property* parent)
{
  geometry_topic_ =
      makeTopic<mesh_msgs::MeshGeometryStamped>("Geometry Topic", "The mesh.", parent, this);
}

void SourceProperties::addColors(rviz::Property* parent)
{
  colors_topic_ = makeTopic<mesh_msgs::MeshVertexColorsStamped>(
      "Vertex Colors Topic", "The colors of the vertices.", parent, this);
  colors_service_ =
      makeService("Vertex Color Service Name", "get_vertex_colors", "vertex colors", parent, this);
}

void SourceProperties::addTextures(rviz::Property* parent)
{
  materials_service_ =
      makeService("Material Service Name", "get_materials", "materials", parent, this);
  texture_service_ = makeService("Texture Service Name", "get_texture", "textures", parent, this);
  materials_topic_ = makeTopic<mesh_msgs::MeshMaterialsStamped>(
      "Materials Topic", "The materials of the faces, where they are published.", parent, this);
  textures_topic_ = makeTopic<mesh_msgs::MeshTexture>(
      "Textures Topic", "The images of the materials, where they are published.", parent, this);
}

void SourceProperties::addCosts(CostProperties* costs)
{
  costs_ = costs;
  connect(costs_, SIGNAL(topicsChanged()), SIGNAL(changed()));
}

void SourceProperties::addLabels(rviz::Property* parent)
{
  labels_topic_ =
      makeTopic<mesh_msgs::MeshFaceCluster>("Labels Topic", "Labels as they change.", parent, this);
}

void SourceProperties::show(bool colors, bool textures)
{
  colors_topic_->setHidden(!colors || given_);
  colors_service_->setHidden(!colors || given_);
  const std::initializer_list<rviz::Property*> of_textures = {materials_service_, texture_service_,
                                                              materials_topic_, textures_topic_};
  for (rviz::Property* property : of_textures) {
    property->setHidden(!textures || given_);
  }
}

MeshSource SourceProperties::source() const
{
  if (given_) {
    return *given_;
  }
  MeshSource source;
  source.geometry_topic = geometry_topic_->getTopicStd();
  source.costs_topic = costs_->costsTopic();
  source.face_costs_topic = costs_->faceCostsTopic();
  source.colors_topic = colors_topic_->getTopicStd();
  source.labels_topic = labels_topic_->getTopicStd();
  return source;
}

void SourceProperties::give(const MeshSource& source)
{
  given_ = source;
  geometry_topic_->hide();
  labels_topic_->hide();
  costs_->setTopicsHidden(true);
}

void SourceProperties::setGeometryTopic(const QString& topic)
{
  geometry_topic_->setString(topic);
}

void SourceProperties::proposeTopics(const QString& costs, const QString& colors)
{
  if (colors_topic_->getTopic().isEmpty()) {
    colors_topic_->setString(colors);
  }
  if (costs_->costsTopic().empty()) {
    costs_->setCostsTopic(costs.toStdString());
  }
}

std::string SourceProperties::updatesTopic() const
{
  if (!given_) {
    return costs_->updateTopic();
  }
  return given_->costs_topic.empty() ? std::string() : given_->costs_topic + "/updates";
}

std::string SourceProperties::materialsTopic() const
{
  return given_ ? std::string() : materials_topic_->getTopicStd();
}

std::string SourceProperties::texturesTopic() const
{
  return given_ ? std::string() : textures_topic_->getTopicStd();
}

ServiceNames SourceProperties::services() const
{
  ServiceNames names;
  names.colors = colors_service_->getStdString();
  names.materials = materials_service_->getStdString();
  names.texture = texture_service_->getStdString();
  names.geometry_topic = source().geometry_topic;
  names.service_namespace = source().service_namespace;
  return names;
}

}  // namespace rviz_mesh_plugin
