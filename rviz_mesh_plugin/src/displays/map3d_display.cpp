#include "displays/map3d_display.h"

#include <exception>

#include <ros/names.h>
#include <ros/param.h>
#include <ros/this_node.h>
#include <rviz/config.h>
#include <rviz/display_context.h>
#include <rviz/load_resource.h>
#include <rviz/properties/tf_frame_property.h>

#include "displays/cluster_label_display.h"
#include "displays/map3d_status.h"
#include "displays/map_file_property.h"
#include "displays/textured_mesh_display.h"
#include "map_server/map_server_run.h"

namespace rviz_mesh_plugin {
namespace {

/// "Frame": that of the file.
constexpr const char* FRAME_OF_FILE = "<As in the file>";

/// The parameter that overrides the path of a display of this name; empty where no parameter can
/// have such a name.
std::string fileParameter(const std::string& display)
{
  const std::string name = ros::this_node::getName() + "/rviz_map_plugin/" + display;
  std::string error;
  return ros::names::validate(name, error) ? name : std::string();
}

void addChildDisplay(rviz::DisplayGroup& group, rviz::DisplayContext* context,
                     rviz::Display* display, const char* class_name, const char* name)
{
  display->setClassId(QString("rviz_mesh_plugin/") + class_name);
  display->setName(name);
  display->setIcon(
      rviz::loadPixmap(QString("package://rviz_mesh_plugin/icons/classes/%1.png").arg(class_name)));
  group.addDisplay(display);
  display->initialize(context);
  display->setEnabled(true);
}

Map3DState stateOf(const MapSession& session)
{
  Map3DState state;
  state.file = session.file();
  state.look_problem = session.lookProblem();
  state.problem = session.problem();
  state.progress = session.progress();
  state.label = session.label();
  if (const MapServerRun* server = session.server()) {
    state.started = true;
    state.pid = server->process().pid();
    state.server = server->ns();
    state.ending = server->ending();
    state.seconds = std::chrono::duration<double>(server->age()).count();
  }
  return state;
}

}  // namespace

Map3DDisplay::Map3DDisplay() : session_(std::make_unique<MapSession>(findMapServer)), lines_(this)
{
  file_property_ = new MapFileProperty(
      "Map file path", NO_MAP_FILE,
      "A map (.h5), or a mesh: .ply, .obj, .stl, .dae, .glb, .gltf. It is loaded again when it "
      "changes. A relative path counts from where RViz was started.",
      this, SLOT(onFile()), this);
  frame_property_ =
      new rviz::TfFrameProperty("Frame", FRAME_OF_FILE, "The frame that the map lies in.", this,
                                nullptr, true, SLOT(onFrame()), this);
  QObject::connect(
      frame_property_,
      static_cast<void (rviz::TfFrameProperty::*)(rviz::EditableEnumProperty*)>(
          &rviz::EditableEnumProperty::requestOptions),
      this, [](rviz::EditableEnumProperty* property) { property->addOption(FRAME_OF_FILE); });
}

Map3DDisplay::~Map3DDisplay() = default;

void Map3DDisplay::onInitialize()
{
  lines_.attempt([this] {
    frame_property_->setFrameManager(context_->getFrameManager());
    createChildren();
  });
}

void Map3DDisplay::createChildren()
{
  if (!labels_) {
    labels_ = new ClusterLabelDisplay;
    addChildDisplay(*this, context_, labels_, "ClusterLabel", "ClusterLabel");
  }
  if (!mesh_) {
    mesh_ = new TexturedMeshDisplay;
    addChildDisplay(*this, context_, mesh_, "TexturedMesh", "Mesh");
  }
  applySource();
}

TexturedMeshDisplay* Map3DDisplay::meshDisplay() const
{
  return static_cast<TexturedMeshDisplay*>(mesh_.data());
}

ClusterLabelDisplay* Map3DDisplay::labelDisplay() const
{
  return static_cast<ClusterLabelDisplay*>(labels_.data());
}

void Map3DDisplay::load(const rviz::Config& config)
{
  lines_.attempt([&] {
    createChildren();
    // The children are not in a list of displays, but, as the released plugin has it, values like
    // the properties.
    rviz::Display::load(config);
    labels_->load(config.mapGetChild("ClusterLabel"));
    mesh_->load(config.mapGetChild("Mesh"));
    applyFileParameter();
  });
}

void Map3DDisplay::save(rviz::Config config) const
{
  rviz::Display::save(config);
  if (labels_) {
    labels_->save(config.mapMakeChild("ClusterLabel"));
  }
  if (mesh_) {
    mesh_->save(config.mapMakeChild("Mesh"));
  }
}

void Map3DDisplay::applyFileParameter()
{
  try {
    const std::string name = fileParameter(getNameStd());
    std::string path;
    if (!name.empty() && ros::param::get(name, path) && !path.empty()) {
      file_property_->setStdString(path);
    }
  } catch (const std::exception& error) {
    ROS_WARN("the parameter rviz_map_plugin/%s is not used: %s", getNameStd().c_str(),
             error.what());
  }
}

Qt::ItemFlags Map3DDisplay::getViewFlags(int column) const
{
  return rviz::DisplayGroup::getViewFlags(column) & ~Qt::ItemFlags(Qt::ItemIsDropEnabled);
}

void Map3DDisplay::onEnable()
{
  lines_.attempt([this] { session_->retry(); });
}

void Map3DDisplay::onDisable()
{
  clearStatuses();
  lines_.forget();
}

void Map3DDisplay::reset()
{
  rviz::DisplayGroup::reset();
  lines_.forget();
  lines_.attempt([this] {
    session_->retry();
    applySource();
  });
}

void Map3DDisplay::onFile()
{
  lines_.attempt([this] {
    session_->setFile(file_property_->getStdString());
    applySource();
  });
}

void Map3DDisplay::onFrame()
{
  lines_.attempt([this] { applySource(); });
}

std::string Map3DDisplay::frame() const
{
  const std::string frame = frame_property_->getFrameStd();
  return frame == FRAME_OF_FILE ? std::string() : frame;
}

void Map3DDisplay::applySource()
{
  const MapServerRun* server = session_->server();
  const MeshSource source = server ? server->source(frame()) : MeshSource();
  if (labels_) {
    labelDisplay()->setSource(source);
  }
  if (mesh_) {
    meshDisplay()->setSource(source);
  }
  shown_namespace_ = source.service_namespace;
}

void Map3DDisplay::update(float wall_dt, float ros_dt)
{
  lines_.repeat([this] {
    session_->update(threaded_nh_);
    const MapServerRun* server = session_->server();
    if (shown_namespace_ != (server ? server->ns() : std::string())) {
      applySource();
    }
    const Map3DState state = stateOf(*session_);
    lines_.report("Map", mapStatus(state));
    lines_.report("IO", ioStatus(state));
    lines_.report("Label", labelStatus(state));
  });
  rviz::DisplayGroup::update(wall_dt, ros_dt);
}

}  // namespace rviz_mesh_plugin
