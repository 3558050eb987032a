#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <mesh_msgs/GetLabelColors.h>
#include <mesh_msgs/GetLabeledClusters.h>
#include <mesh_msgs/MeshFaceCluster.h>
#include <mesh_msgs/MeshFaceClusterStamped.h>
#include <mesh_msgs/MeshLabelColors.h>
#include <mesh_msgs/SetLabelColor.h>
#include <ros/callback_queue.h>
#include <ros/service_server.h>
#include <ros/spinner.h>
#include <ros/subscriber.h>

#include "display_fixture.h"
#include "displays/cluster_label_display.h"

/// What hdf5_map_server has for labels, in this process, on threads of its own.
class LabelServer
{
 public:
  explicit LabelServer(const std::string& name_space) : spinner_(1, &queue_)
  {
    node_.setCallbackQueue(&queue_);
    labels = node_.advertise<mesh_msgs::MeshFaceCluster>(name_space + "/new_cluster_label", 100);
    colors = node_.advertise<mesh_msgs::MeshLabelColors>(name_space + "/label_colors", 10, true);
    clusters_ = node_.advertiseService(name_space + "/get_labeled_clusters",
                                       &LabelServer::getClusters, this);
    color_ = node_.advertiseService(name_space + "/set_label_color", &LabelServer::setColor, this);
    own_colors_ =
        node_.advertiseService(name_space + "/get_label_colors", &LabelServer::getColors, this);
    spinner_.start();
  }

  ~LabelServer()
  {
    ending_ = true;
    spinner_.stop();
    // They use the queue, which is gone before them.
    labels.shutdown();
    colors.shutdown();
    clusters_.shutdown();
    color_.shutdown();
    own_colors_.shutdown();
    edits_.shutdown();
  }

  void listen(const std::string& name_space)
  {
    edits_ = node_.subscribe(name_space + "/cluster_label", 10, &LabelServer::take, this);
  }

  /// What get_labeled_clusters says; in place of what that label had.
  void addLabel(const std::string& label, const std::vector<std::uint32_t>& faces)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto known =
        std::find_if(all_.begin(), all_.end(), [&](const auto& one) { return one.label == label; });
    all_.erase(known, known == all_.end() ? known : known + 1);
    all_.push_back(cluster(label, faces));
  }

  /// So many of the questions for all labels are answered, the others wait; by default all are.
  void answer(int questions) { answered_ = questions; }
  /// The questions for all labels, also those that are not answered.
  int asked() const { return asked_; }

  static mesh_msgs::MeshFaceCluster cluster(const std::string& label,
                                            const std::vector<std::uint32_t>& faces)
  {
    mesh_msgs::MeshFaceCluster message;
    message.label = label;
    message.face_indices = faces;
    return message;
  }

  std::vector<mesh_msgs::MeshFaceClusterStamped> edits()
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    return received_;
  }

  /// What get_label_colors says, until the next time.
  void setColors(const mesh_msgs::MeshLabelColors& colors)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    own_ = colors;
  }

  /// The uuids that colors were asked for.
  std::vector<std::string> colorsAsked()
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    return colors_asked_;
  }

  std::vector<mesh_msgs::SetLabelColor::Request> colorsSet()
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    return colors_set_;
  }

  ros::Publisher labels;
  ros::Publisher colors;
  std::string refusal;                  ///< of colors; empty: they are taken
  std::function<void()> before_colors;  ///< is called before they are

 private:
  bool getClusters(mesh_msgs::GetLabeledClusters::Request& request,
                   mesh_msgs::GetLabeledClusters::Response& response)
  {
    const int number = ++asked_;
    while (number > answered_ && !ending_) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    const std::lock_guard<std::mutex> lock(mutex_);
    response.clusters = all_;
    return request.uuid == "mesh";
  }

  bool setColor(mesh_msgs::SetLabelColor::Request& request,
                mesh_msgs::SetLabelColor::Response& /*response*/)
  {
    if (before_colors) {
      before_colors();
    }
    const std::lock_guard<std::mutex> lock(mutex_);
    colors_set_.push_back(request);
    if (!refusal.empty()) {
      throw std::runtime_error(refusal);
    }
    return true;
  }

  bool getColors(mesh_msgs::GetLabelColors::Request& request,
                 mesh_msgs::GetLabelColors::Response& response)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    colors_asked_.push_back(request.uuid);
    response.labels = own_.labels;
    response.colors = own_.colors;
    return true;
  }

  void take(const mesh_msgs::MeshFaceClusterStamped& message)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    received_.push_back(message);
  }

  std::atomic<int> asked_{0};
  std::atomic<int> answered_{std::numeric_limits<int>::max()};
  std::atomic<bool> ending_{false};
  std::mutex mutex_;
  std::vector<mesh_msgs::MeshFaceCluster> all_;
  std::vector<mesh_msgs::MeshFaceClusterStamped> received_;
  std::vector<mesh_msgs::SetLabelColor::Request> colors_set_;
  mesh_msgs::MeshLabelColors own_;
  std::vector<std::string> colors_asked_;
  ros::CallbackQueue queue_;
  ros::NodeHandle node_;
  ros::ServiceServer clusters_;
  ros::ServiceServer color_;
  ros::ServiceServer own_colors_;
  ros::Subscriber edits_;
  ros::AsyncSpinner spinner_;
};

/// A display of labels with topics, services and a mesh of 10 x 10 squares of its own.
class LabelDisplayFixture : public DisplayFixture
{
 protected:
  using Display = rviz_mesh_plugin::ClusterLabelDisplay;

  void SetUp() override
  {
    DisplayFixture::SetUp();
    name_space = std::string("/") + testing::UnitTest::GetInstance()->current_test_info()->name();
    server = std::make_unique<LabelServer>(name_space);
  }

  void TearDown() override
  {
    DisplayFixture::TearDown();
    server.reset();
  }

  Display* createLabels(const std::string& class_id = "rviz_mesh_plugin/ClusterLabel")
  {
    auto* display = createDisplayAs<Display>(class_id);
    set(display, {"Geometry Topic"}, geometry_topic.c_str());
    set(display, {"Labels Topic"}, (name_space + "/new_cluster_label").c_str());
    return display;
  }

  void publishMesh()
  {
    geometry.publish(test_meshes::terrain(10, [](double, double) { return 0.0; }));
  }

  static testing::AssertionResult says(rviz::Display* display, const std::string& name,
                                       const std::string& text)
  {
    if (spinUntil([&] { return status(display, name).find(text) != std::string::npos; })) {
      return testing::AssertionSuccess();
    }
    return testing::AssertionFailure()
           << "status '" << name << "' is '" << status(display, name) << "'";
  }

  /// Own colors, of channels 0..255.
  static mesh_msgs::MeshLabelColors colorsOf(
      const std::map<std::string, osmesa_harness::Rgb>& colors)
  {
    mesh_msgs::MeshLabelColors message;
    message.uuid = "mesh";
    for (const auto& color : colors) {
      const osmesa_harness::Rgb& rgb = color.second;
      message.labels.push_back(color.first);
      message.colors.push_back(
          test_meshes::color(rgb.red / 255.0f, rgb.green / 255.0f, rgb.blue / 255.0f));
    }
    return message;
  }

  osmesa_harness::Image picture()
  {
    viewFromAbove();
    return grab();
  }

  std::string name_space;
  std::unique_ptr<LabelServer> server;
};
