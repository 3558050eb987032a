// The three ways to show a mesh in RViz that benchmark/rviz_display.cpp compares.
#pragma once

#include <OgreManualObject.h>
#include <OgreMaterialManager.h>
#include <OgreResourceGroupManager.h>
#include <OgreSceneManager.h>
#include <OgreSceneNode.h>
#include <OgreTechnique.h>
#include <mesh_msgs/MeshGeometryStamped.h>
#include <mesh_msgs/MeshMaterialsStamped.h>
#include <mesh_msgs/MeshTexture.h>
#include <mesh_msgs/MeshVertexCostsSparseStamped.h>
#include <mesh_msgs/MeshVertexCostsStamped.h>
#include <ros/node_handle.h>
#include <rviz/properties/property.h>
#include <visualization_msgs/Marker.h>
#include <boost/make_shared.hpp>

#include <QTimer>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "rviz_stage.h"
#include "world.h"

namespace rviz_benchmark {

constexpr std::array<float, 3> GREEN{0.0f, 1.0f, 0.0f};

/// One way to show it. All calls come from the GUI thread.
class Subject
{
 public:
  virtual ~Subject() = default;
  /// What RViz is to watch.
  virtual void create() = 0;
  /// Whether messages would arrive.
  virtual bool ready() const { return true; }
  /// Makes the message; not measured.
  virtual void prepare(const World& world) = 0;
  /// Hands it over: from here on time is taken. It arrives as RViz's own event loop gets to it.
  virtual void show() = 0;
  /// Makes what the layers are switched with; not measured.
  virtual void prepareLayers(const World& world) = 0;
  virtual void switchTo(int layer) = 0;
};

/// rviz_mesh_plugin/TexturedMesh.
class MeshSubject : public Subject
{
 public:
  void create() override
  {
    display_ = Stage::createDisplay("rviz_mesh_plugin/TexturedMesh");
    display_->subProp("Show Wireframe")->setValue(false);
    display_->subProp("Show Normals")->setValue(false);
    geometry_ = node_.advertise<mesh_msgs::MeshGeometryStamped>("/benchmark/mesh", 1);
    costs_ = node_.advertise<mesh_msgs::MeshVertexCostsStamped>("/benchmark/vertex_costs", 4);
    updates_ = node_.advertise<mesh_msgs::MeshVertexCostsSparseStamped>(
        "/benchmark/vertex_costs/updates", 100);
    materials_ = node_.advertise<mesh_msgs::MeshMaterialsStamped>("/benchmark/materials", 1);
    textures_ = node_.advertise<mesh_msgs::MeshTexture>("/benchmark/textures", 1);
    display_->subProp("Geometry Topic")->setValue("/benchmark/mesh");
    display_->subProp("Display Type")
        ->subProp("Vertex Costs Topic")
        ->setValue("/benchmark/vertex_costs");
    display_->subProp("Display Type")->subProp("Materials Topic")->setValue("/benchmark/materials");
    display_->subProp("Display Type")->subProp("Textures Topic")->setValue("/benchmark/textures");
  }

  bool ready() const override
  {
    return geometry_.getNumSubscribers() > 0 && costs_.getNumSubscribers() > 0 &&
           updates_.getNumSubscribers() > 0 && textures_.getNumSubscribers() > 0;
  }

  void prepare(const World& world) override
  {
    message_ = boost::make_shared<mesh_msgs::MeshGeometryStamped>();
    message_->header.frame_id = "map";
    message_->uuid = "benchmark";
    message_->mesh_geometry.vertices.reserve(world.vertices.size());
    for (const auto& p : world.vertices) {
      geometry_msgs::Point point;
      point.x = p[0];
      point.y = p[1];
      point.z = p[2];
      message_->mesh_geometry.vertices.push_back(point);
    }
    message_->mesh_geometry.faces.resize(world.faces.size());
    for (std::size_t i = 0; i < world.faces.size(); ++i) {
      std::copy(world.faces[i].begin(), world.faces[i].end(),
                message_->mesh_geometry.faces[i].vertex_indices.begin());
    }
  }

  void show() override
  {
    geometry_.publish(message_);
    message_.reset();
  }

  void prepareLayers(const World& world) override
  {
    for (int layer = 0; layer < 2; ++layer) {
      auto message = boost::make_shared<mesh_msgs::MeshVertexCostsStamped>();
      message->header.frame_id = "map";
      message->uuid = "benchmark";
      message->type = "layer " + std::to_string(layer);
      message->mesh_vertex_costs.costs.resize(world.vertices.size());
      for (std::size_t i = 0; i < world.vertices.size(); ++i) {
        message->mesh_vertex_costs.costs[i] = world.cost(layer, i);
      }
      costs_.publish(message);
    }
    display_->subProp("Display Type")->setValue("Vertex Costs");
  }

  void switchTo(int layer) override
  {
    display_->subProp("Display Type")
        ->subProp("Vertex Costs Type")
        ->setValue(QString("layer %1").arg(layer));
  }

  /// New values of a layer, of vertices in no order.
  static boost::shared_ptr<mesh_msgs::MeshVertexCostsSparseStamped> makeUpdate(const World& world,
                                                                               int layer,
                                                                               std::size_t count)
  {
    auto message = boost::make_shared<mesh_msgs::MeshVertexCostsSparseStamped>();
    message->header.frame_id = "map";
    message->uuid = "benchmark";
    message->type = "layer " + std::to_string(layer);
    std::uint64_t random = 1;
    for (std::size_t i = 0; i < count; ++i) {
      random = random * 6364136223846793005u + 1442695040888963407u;
      const auto vertex = static_cast<std::uint32_t>((random >> 33) % world.vertices.size());
      message->mesh_vertex_costs.vertices.push_back(vertex);
      message->mesh_vertex_costs.costs.push_back(world.cost(1 - layer, vertex));
    }
    return message;
  }
  void update(const boost::shared_ptr<mesh_msgs::MeshVertexCostsSparseStamped>& message)
  {
    updates_.publish(message);
  }

  /// All faces have one material with a texture.
  void prepareMaterials(const World& world)
  {
    auto message = boost::make_shared<mesh_msgs::MeshMaterialsStamped>();
    message->header.frame_id = "map";
    message->uuid = "benchmark";
    mesh_msgs::MeshMaterials& materials = message->mesh_materials;
    materials.materials.resize(1);
    materials.materials[0].color.a = 1.0f;
    materials.materials[0].has_texture = true;
    materials.clusters.resize(1);
    for (std::size_t face = 0; face < world.faces.size(); ++face) {
      materials.clusters[0].face_indices.push_back(static_cast<std::uint32_t>(face));
    }
    materials.cluster_materials = {0};
    materials.vertex_tex_coords.resize(world.vertices.size());
    for (std::size_t i = 0; i < world.vertices.size(); ++i) {
      materials.vertex_tex_coords[i].u = world.cost(0, i);
      materials.vertex_tex_coords[i].v = world.cost(1, i);
    }
    materials_.publish(message);
    display_->subProp("Display Type")->setValue("Textures");
  }
  /// Of so many pixels a side.
  void prepareTexture(std::uint32_t side) { texture_ = makeTexture(side); }
  void showTexture() { textures_.publish(std::exchange(texture_, nullptr)); }

 private:
  static boost::shared_ptr<mesh_msgs::MeshTexture> makeTexture(std::uint32_t side)
  {
    auto message = boost::make_shared<mesh_msgs::MeshTexture>();
    message->uuid = "benchmark";
    message->image.width = message->image.height = side;
    message->image.encoding = "rgb8";
    message->image.step = 3 * side;
    message->image.data.resize(std::size_t{3} * side * side);
    for (std::size_t i = 0; i < message->image.data.size(); ++i) {
      message->image.data[i] = static_cast<std::uint8_t>(i * 2654435761u >> 13);
    }
    return message;
  }

  ros::NodeHandle node_;
  ros::Publisher geometry_;
  ros::Publisher costs_;
  ros::Publisher updates_;
  ros::Publisher materials_;
  ros::Publisher textures_;
  boost::shared_ptr<mesh_msgs::MeshTexture> texture_;
  boost::shared_ptr<mesh_msgs::MeshGeometryStamped> message_;
  rviz::Display* display_ = nullptr;
};

/// rviz/Marker with a visualization_msgs/Marker of type TRIANGLE_LIST.
class MarkerSubject : public Subject
{
 public:
  void create() override
  {
    auto* display = Stage::createDisplay("rviz/Marker");
    markers_ = node_.advertise<visualization_msgs::Marker>("/benchmark/marker", 1);
    display->subProp("Marker Topic")->setValue("/benchmark/marker");
  }

  bool ready() const override { return markers_.getNumSubscribers() > 0; }

  void prepare(const World& world) override { layers_[0] = message(world, -1); }

  void show() override
  {
    markers_.publish(layers_[0]);
    layers_[0].reset();
  }

  void prepareLayers(const World& world) override
  {
    layers_[0] = message(world, 0);
    layers_[1] = message(world, 1);
  }

  void switchTo(int layer) override { markers_.publish(layers_[layer]); }

 private:
  static boost::shared_ptr<visualization_msgs::Marker> message(const World& world, int layer)
  {
    auto marker = boost::make_shared<visualization_msgs::Marker>();
    marker->header.frame_id = "map";
    marker->type = visualization_msgs::Marker::TRIANGLE_LIST;
    marker->pose.orientation.w = 1.0;
    marker->scale.x = marker->scale.y = marker->scale.z = 1.0;
    marker->color.g = marker->color.a = 1.0f;
    marker->points.reserve(3 * world.faces.size());
    marker->colors.reserve(3 * world.faces.size());
    for (const auto& face : world.faces) {
      for (const std::uint32_t vertex : face) {
        geometry_msgs::Point point;
        point.x = world.vertices[vertex][0];
        point.y = world.vertices[vertex][1];
        point.z = world.vertices[vertex][2];
        marker->points.push_back(point);
        // From the start: RViz draws no colors that come to an object of the same size later.
        const auto c = layer < 0 ? GREEN : world.color(layer, vertex);
        std_msgs::ColorRGBA color;
        color.r = c[0];
        color.g = c[1];
        color.b = c[2];
        color.a = 1.0f;
        marker->colors.push_back(color);
      }
    }
    return marker;
  }

  ros::NodeHandle node_;
  ros::Publisher markers_;
  std::array<boost::shared_ptr<visualization_msgs::Marker>, 2> layers_;
};

/// One Ogre::ManualObject with shared vertices, filled in the GUI thread.
class ManualObjectSubject : public Subject
{
 public:
  ~ManualObjectSubject() override
  {
    if (object_) {
      Stage::sceneManager()->destroyManualObject(object_);
    }
  }

  void create() override
  {
    object_ = Stage::sceneManager()->createManualObject("benchmark");
    Stage::sceneManager()->getRootSceneNode()->attachObject(object_);
    material_ = Ogre::MaterialManager::getSingleton().create(
        "benchmark", Ogre::ResourceGroupManager::DEFAULT_RESOURCE_GROUP_NAME);
    material_->setCullingMode(Ogre::CULL_NONE);
    Ogre::Pass* pass = material_->getTechnique(0)->getPass(0);
    pass->setVertexColourTracking(Ogre::TVC_AMBIENT | Ogre::TVC_DIFFUSE);
  }

  void prepare(const World& world) override
  {
    world_ = &world;
    normals_.assign(world.vertices.size(), Ogre::Vector3::ZERO);
    for (const auto& face : world.faces) {
      const Ogre::Vector3 a = at(face[0]), b = at(face[1]), c = at(face[2]);
      const Ogre::Vector3 normal = (b - a).crossProduct(c - a);
      for (const std::uint32_t vertex : face) {
        normals_[vertex] += normal;
      }
    }
  }

  void show() override
  {
    QTimer::singleShot(0, [this] { fill(-1); });
  }

  void prepareLayers(const World&) override {}

  void switchTo(int layer) override
  {
    QTimer::singleShot(0, [this, layer] { fill(layer); });
  }

 private:
  Ogre::Vector3 at(std::uint32_t vertex) const
  {
    return Ogre::Vector3(world_->vertices[vertex].data());
  }

  void fill(int layer)
  {
    object_->clear();
    object_->estimateVertexCount(world_->vertices.size());
    object_->estimateIndexCount(3 * world_->faces.size());
    object_->begin("benchmark", Ogre::RenderOperation::OT_TRIANGLE_LIST);
    for (std::size_t i = 0; i < world_->vertices.size(); ++i) {
      object_->position(at(i));
      object_->normal(normals_[i].normalisedCopy());
      const auto c = layer < 0 ? GREEN : world_->color(layer, i);
      object_->colour(c[0], c[1], c[2]);
    }
    for (const auto& face : world_->faces) {
      object_->triangle(face[0], face[1], face[2]);
    }
    object_->end();
    Stage::manager()->queueRender();
  }

  const World* world_ = nullptr;
  std::vector<Ogre::Vector3> normals_;
  Ogre::ManualObject* object_ = nullptr;
  Ogre::MaterialPtr material_;
};

inline std::unique_ptr<Subject> makeSubject(const std::string& name)
{
  if (name == "mesh") {
    return std::make_unique<MeshSubject>();
  }
  if (name == "marker") {
    return std::make_unique<MarkerSubject>();
  }
  if (name == "manual_object") {
    return std::make_unique<ManualObjectSubject>();
  }
  return nullptr;
}

}  // namespace rviz_benchmark
