#include "displays/map3d_display.h"

#include <exception>

#include <ros/names.h>
#include <ros/param.h>
#include <ros/this_node.h>
#include <rviz/config.h>
#include <rviz/display_context.h>
#include <rviz/load_resource.h>
#include <rviz/properties/line_edit_with_button.h>
#include <rviz/properties/string_property.h>
#include <rviz/properties/tf_frame_property.h>
#include <QDir>
#include <QFileDialog>
#include <QFileInfo>
#include <QPushButton>

#include "displays/map3d_status.h"

namespace rviz_mesh_plugin {
namespace {

/// "Frame": that of the file.
constexpr const char* FRAME_OF_FILE = "<As in the file>";

constexpr const char* FILTERS =
    "Maps and meshes (*.h5 *.hdf5 *.ply *.obj *.stl *.off *.dae *.zae *.fbx *.3ds *.glb *.gltf);;"
    "Maps (*.h5 *.hdf5);;All files (*)";

/// The path of a map file: to be typed, or chosen with a button.
class MapFileProperty : public rviz::StringProperty
{
 public:
  using rviz::StringProperty::StringProperty;

  QWidget* createEditor(QWidget* parent, const QStyleOptionViewItem& option) override;

  /// Opens the file dialog and returns; the choice becomes the value.
  void openDialog(QWidget* parent);
};

/// Edits a MapFileProperty.
class MapFileEditor : public rviz::LineEditWithButton
{
 public:
  MapFileEditor(MapFileProperty* property, QWidget* parent)
      : rviz::LineEditWithButton(parent), property_(property)
  {
    button()->setToolTip("Choose a file");
  }

 protected:
  void onButtonClick() override
  {
    MapFileProperty* property = property_;
    QWidget* parent = window();
    // Some window managers end the editor as soon as the dialog has the focus, and then its text
    // would replace the choice: better at once, everywhere.
    deleteLater();
    property->openDialog(parent);
  }

 private:
  MapFileProperty* property_;
};

QWidget* MapFileProperty::createEditor(QWidget* parent, const QStyleOptionViewItem& /*option*/)
{
  return new MapFileEditor(this, parent);
}

void MapFileProperty::openDialog(QWidget* parent)
{
  auto* dialog = new QFileDialog(parent, getName(), QString(), FILTERS);
  dialog->setAttribute(Qt::WA_DeleteOnClose);
  dialog->setFileMode(QFileDialog::ExistingFile);
  const QFileInfo chosen(QString::fromStdString(resolvedPath(getStdString())));
  if (chosen.dir().exists()) {
    dialog->setDirectory(chosen.dir());
    dialog->selectFile(chosen.fileName());
  }
  // Where the property is deleted first, Qt ends the connection.
  connect(dialog, &QFileDialog::fileSelected, this,
          [this](const QString& path) { setValue(path); });
  connect(this, &QObject::destroyed, dialog, &QWidget::close);
  dialog->open();
}

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
  if (const MapServerRun* server = session.server()) {
    state.started = true;
    state.pid = server->process().processId();
    state.server = server->ns();
    state.ending = server->ending();
    state.seconds = std::chrono::duration<double>(server->age()).count();
    state.progress = server->progress();
    state.label = server->label();
  }
  return state;
}

}  // namespace

Map3DDisplay::Map3DDisplay() : session_(findMapServer), lines_(this)
{
  file_property_ =
      new MapFileProperty("Map file path", NO_MAP_FILE,
                          "A map (.h5), or a mesh: .ply, .obj, .stl, .off, .dae, .zae, .fbx, .3ds, "
                          ".glb, .gltf. It is loaded again when it changes. A relative path counts "
                          "from where RViz was started.",
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
    if (getClassId() != "rviz_mesh_plugin/Map3D") {
      mesh_->beginAsReleased();
    }
  }
  applySource();
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
  lines_.attempt([this] { session_.retry(); });
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
    session_.retry();
    applySource();
  });
}

void Map3DDisplay::onFile()
{
  lines_.attempt([this] {
    session_.setFile(file_property_->getStdString());
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
  const MapServerRun* server = session_.server();
  const MeshSource source = server ? server->source(frame()) : MeshSource();
  if (labels_) {
    labels_->setSource(source);
  }
  if (mesh_) {
    mesh_->setSource(source);
  }
  shown_namespace_ = source.service_namespace;
}

void Map3DDisplay::update(float wall_dt, float ros_dt)
{
  lines_.repeat([this] {
    session_.update(threaded_nh_);
    const MapServerRun* server = session_.server();
    if (shown_namespace_ != (server ? server->ns() : std::string())) {
      applySource();
    }
    const Map3DState state = stateOf(session_);
    lines_.report("Map", mapStatus(state));
    lines_.report("IO", ioStatus(state));
    lines_.report("Label", labelStatus(state));
    lines_.report("Parts", state.started ? partsStatus(*this) : std::nullopt);
  });
  rviz::DisplayGroup::update(wall_dt, ros_dt);
}

}  // namespace rviz_mesh_plugin
