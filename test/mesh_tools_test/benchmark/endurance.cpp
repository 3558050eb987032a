// The C++ side of endurance.py: what stays in RViz's memory after long use.
//
//     headless --master endurance_benchmark FOLDER cycles COUNT
//     headless --master endurance_benchmark FOLDER costs SECONDS
//     headless --master endurance_benchmark FOLDER loads COUNT
//
// FOLDER has vertices.f32 and faces.u32. Prints lines "name step value": bytes that are resident,
// milliseconds.
#include <mesh_msgs/MeshFaceCluster.h>
#include <mesh_msgs/MeshFaceClusterStamped.h>
#include <ros/init.h>
#include <rviz/properties/property.h>
#include <rviz/tool_manager.h>
#include "displays/cluster_label_display.h"
#include "panel/cluster_label_panel.h"
#include "tools/cluster_label_tool.h"

#include <QMainWindow>

#include <cstdio>
#include <iostream>

#include "rviz_subjects.h"

namespace rviz_benchmark::endurance {
namespace {

using rviz_mesh_plugin::ClusterLabelPanel;
using rviz_mesh_plugin::ClusterLabelTool;

constexpr int WIDTH = 1280;
constexpr int HEIGHT = 960;
constexpr int PATIENCE = 120000;  // milliseconds

void tell(const char* name, int step, double value)
{
  std::printf("%s %d %.9g\n", name, step, value);
  std::fflush(stdout);
}

void waitUntil(const char* what, const std::function<bool()>& condition)
{
  const auto start = Clock::now();
  while (!condition()) {
    if (milliseconds(Clock::now() - start) > PATIENCE) {
      throw std::runtime_error(std::string("within two minutes there was no ") + what);
    }
    QApplication::processEvents();
    QThread::msleep(1);
  }
}

/// Of this process, as the system counts it.
double resident()
{
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.compare(0, 6, "VmRSS:") == 0) {
      return 1024.0 * std::stod(line.substr(6));
    }
  }
  return 0.0;
}

void lookAtAll(const World& world)
{
  const double x = 0.5 * (world.lower[0] + world.upper[0]);
  const double y = 0.5 * (world.lower[1] + world.upper[1]);
  const double z = 0.5 * (world.lower[2] + world.upper[2]);
  const double size = std::max(world.upper[0] - world.lower[0], world.upper[1] - world.lower[1]);
  Stage::lookAt({x - 0.9 * size, y, z + 0.7 * size}, {x, y, z});
}

boost::shared_ptr<mesh_msgs::MeshGeometryStamped> makeMesh(const World& world,
                                                           const std::string& uuid)
{
  auto message = boost::make_shared<mesh_msgs::MeshGeometryStamped>();
  message->header.frame_id = "map";
  message->uuid = uuid;
  auto& geometry = message->mesh_geometry;
  geometry.vertices.resize(world.vertices.size());
  for (std::size_t i = 0; i < world.vertices.size(); ++i) {
    geometry.vertices[i].x = world.vertices[i][0];
    geometry.vertices[i].y = world.vertices[i][1];
    geometry.vertices[i].z = world.vertices[i][2];
  }
  geometry.faces.resize(world.faces.size());
  for (std::size_t i = 0; i < world.faces.size(); ++i) {
    std::copy(world.faces[i].begin(), world.faces[i].end(),
              geometry.faces[i].vertex_indices.begin());
  }
  return message;
}

/// How long drawing took, of each frame since it was asked last.
class FrameTimes : public Ogre::FrameListener
{
 public:
  FrameTimes() { Ogre::Root::getSingleton().addFrameListener(this); }
  ~FrameTimes() override { Ogre::Root::getSingleton().removeFrameListener(this); }

  double count() const { return static_cast<double>(times_.size()); }
  double quantile(double part)
  {
    std::sort(times_.begin(), times_.end());
    return times_.empty() ? 0.0 : times_[static_cast<std::size_t>(part * (count() - 1.0))];
  }
  void forget() { times_.clear(); }

 private:
  bool frameStarted(const Ogre::FrameEvent& /*event*/) override
  {
    start_ = Clock::now();
    return true;
  }
  bool frameEnded(const Ogre::FrameEvent& /*event*/) override
  {
    times_.push_back(milliseconds(Clock::now() - start_));
    return true;
  }

  std::vector<double> times_;
  Clock::time_point start_;
};

/// Stores labels, and forgets them.
class LabelOwner
{
 public:
  LabelOwner()
      : labels_(node_.advertise<mesh_msgs::MeshFaceCluster>("/endurance/new_cluster_label", 100)),
        edits_(node_.subscribe<mesh_msgs::MeshFaceClusterStamped>(
            "/endurance/cluster_label", 10,
            [this](const mesh_msgs::MeshFaceClusterStamped::ConstPtr& edit) {
              labels_.publish(edit->cluster);
            }))
  {
  }

 private:
  ros::NodeHandle node_;
  ros::Publisher labels_;
  ros::Subscriber edits_;
};

/// Displays are added, a mesh is loaded, faces are selected and labelled, all is reset, displays
/// are removed.
void repeatCycles(const World& world, int count)
{
  ros::NodeHandle node;
  LabelOwner owner;
  auto geometry = node.advertise<mesh_msgs::MeshGeometryStamped>("/endurance/mesh", 1, true);
  auto* const tool = dynamic_cast<ClusterLabelTool*>(
      Stage::manager()->getToolManager()->addTool("rviz_mesh_plugin/ClusterLabel"));
  QMainWindow window;
  auto* const panel = new ClusterLabelPanel;
  window.setCentralWidget(panel);
  panel->initialize(Stage::manager());
  panel->setTool(tool);
  window.show();
  std::vector<std::uint32_t> half(world.faces.size() / 2);
  for (std::size_t i = 0; i < half.size(); ++i) {
    half[i] = static_cast<std::uint32_t>(2 * i);
  }
  tell("resident", 0, resident());
  for (int cycle = 1; cycle <= count; ++cycle) {
    auto* const mesh = Stage::createDisplay("rviz_mesh_plugin/TexturedMesh");
    auto* const labels = dynamic_cast<rviz_mesh_plugin::ClusterLabelDisplay*>(
        Stage::createDisplay("rviz_mesh_plugin/ClusterLabel"));
    mesh->subProp("Geometry Topic")->setValue("/endurance/mesh");
    labels->subProp("Geometry Topic")->setValue("/endurance/mesh");
    labels->subProp("Labels Topic")->setValue("/endurance/new_cluster_label");
    waitUntil("subscriber", [&] { return geometry.getNumSubscribers() > 0; });
    const std::string uuid = "mesh " + std::to_string(cycle);
    geometry.publish(makeMesh(world, uuid));
    waitUntil("mesh", [&] { return labels->mesh() && labels->mesh()->uuid == uuid; });
    waitUntil("selection", [&] { return tool->select(labels->mesh(), half).empty(); });
    waitUntil("selected faces", [&] { return tool->selection().count() == half.size(); });
    auto* const session = panel->session();
    waitUntil("session", [&] { return session->isOf(labels->mesh()); });
    waitUntil("label", [&] { return session->assign("tree_1", tool->selection().bits()).empty(); });
    waitUntil("stored label",
              [&] { return labels->labels().count("tree_1") == 1 && session->unstored() == 0; });
    Stage::spinFrames(2);
    mesh->reset();
    labels->reset();
    Stage::spinFrames(2);
    delete labels;
    delete mesh;
    Stage::spinFrames(2);
    if (cycle == 1 || cycle == 10 || cycle % 100 == 0) {
      tell("resident", cycle, resident());
    }
  }
}

/// A layer comes ten times a second, each time with other values.
void streamCosts(const World& world, double seconds)
{
  MeshSubject subject;
  subject.create();
  waitUntil("subscriber", [&] { return subject.ready(); });
  subject.prepare(world);
  subject.show();
  subject.prepareLayers(world);
  subject.switchTo(0);
  Stage::spin(10000);
  ros::NodeHandle node;
  auto costs = node.advertise<mesh_msgs::MeshVertexCostsStamped>("/benchmark/vertex_costs", 4);
  constexpr int PERIOD = 100, REPORTS = 30;
  FrameTimes frames;
  const auto start = Clock::now();
  int step = 0, sent = 0;
  tell("resident", 0, resident());
  while (milliseconds(Clock::now() - start) < 1000.0 * seconds) {
    auto message = boost::make_shared<mesh_msgs::MeshVertexCostsStamped>();
    message->header.frame_id = "map";
    message->uuid = "benchmark";
    message->type = "layer 0";
    message->mesh_vertex_costs.costs.resize(world.vertices.size());
    for (std::size_t i = 0; i < world.vertices.size(); ++i) {
      message->mesh_vertex_costs.costs[i] =
          static_cast<float>((i + static_cast<std::size_t>(sent)) % 1000) * 1e-3f;
    }
    costs.publish(message);
    message.reset();
    ++sent;
    while (milliseconds(Clock::now() - start) < 1.0 * PERIOD * sent) {
      QApplication::processEvents();
      QThread::msleep(1);
    }
    const double left = seconds * step / REPORTS;
    if (milliseconds(Clock::now() - start) >= 1000.0 * (left + seconds / REPORTS)) {
      tell("resident", ++step, resident());
      tell("frames", step, frames.count());
      tell("frame_median", step, frames.quantile(0.5));
      tell("frame_tail", step, frames.quantile(0.95));
      tell("frame_longest", step, frames.quantile(1.0));
      frames.forget();
    }
  }
}

/// Meshes of as many faces are shown one after the other, and the last one is taken away.
void loadAgain(const World& world, int count)
{
  ros::NodeHandle node;
  auto geometry = node.advertise<mesh_msgs::MeshGeometryStamped>("/endurance/mesh", 1, true);
  tell("resident", 0, resident());
  auto* const labels = dynamic_cast<rviz_mesh_plugin::ClusterLabelDisplay*>(
      Stage::createDisplay("rviz_mesh_plugin/ClusterLabel"));
  auto* const mesh = Stage::createDisplay("rviz_mesh_plugin/TexturedMesh");
  mesh->subProp("Geometry Topic")->setValue("/endurance/mesh");
  labels->subProp("Geometry Topic")->setValue("/endurance/mesh");
  waitUntil("subscriber", [&] { return geometry.getNumSubscribers() > 0; });
  for (int i = 1; i <= count; ++i) {
    const std::string uuid = "mesh " + std::to_string(i);
    geometry.publish(makeMesh(world, uuid));
    waitUntil("mesh", [&] { return labels->mesh() && labels->mesh()->uuid == uuid; });
    Stage::spin(5000);
    tell("resident", i, resident());
  }
  delete labels;
  delete mesh;
  geometry.shutdown();  // which keeps its last message
  Stage::spin(2000);
  tell("left", count, resident());
}

}  // namespace

int run(int argc, char** argv)
{
  ros::init(argc, argv, "endurance_benchmark", ros::init_options::AnonymousName);
  const std::string part = argc == 4 ? argv[2] : "";
  if (part != "cycles" && part != "costs" && part != "loads") {
    std::cerr << "usage: endurance_benchmark FOLDER cycles|costs|loads NUMBER\n";
    return 2;
  }
  return rviz_benchmark::run("endurance_benchmark", argc, argv, [&] {
    const World world = readWorld(argv[1]);
    Stage::SetUpTestSuite();
    Stage::manager()->setFixedFrame("map");
    Stage::resizePanel(WIDTH, HEIGHT);
    lookAtAll(world);
    Stage::spinFrames(5);
    const double number = std::stod(argv[3]);
    if (part == "cycles") {
      repeatCycles(world, static_cast<int>(number));
    } else if (part == "costs") {
      streamCosts(world, number);
    } else {
      loadAgain(world, static_cast<int>(number));
    }
  });
}

}  // namespace rviz_benchmark::endurance
