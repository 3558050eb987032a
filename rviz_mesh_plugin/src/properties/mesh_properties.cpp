#include "properties/mesh_properties.h"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include <mesh_msgs/MeshFaceCluster.h>
#include <mesh_msgs/MeshGeometryStamped.h>
#include <mesh_msgs/MeshMaterialsStamped.h>
#include <mesh_msgs/MeshTexture.h>
#include <mesh_msgs/MeshVertexColorsStamped.h>
#include <rviz/config.h>
#include <rviz/properties/int_property.h>

#include "properties/cost_properties.h"

namespace rviz_mesh_plugin {
namespace {

constexpr std::array<std::pair<const char*, DisplayType>, 8> DISPLAY_TYPES{
    {{"Automatic", DisplayType::AUTOMATIC},
     {"Fixed Color", DisplayType::FIXED_COLOR},
     {"Vertex Color", DisplayType::VERTEX_COLOR},
     {"Textures", DisplayType::TEXTURES},
     {"Vertex Costs", DisplayType::VERTEX_COSTS},
     {"Height", DisplayType::HEIGHT},
     {"Contour Lines", DisplayType::CONTOUR_LINES},
     {"Hide Faces", DisplayType::HIDE_FACES}}};

const Ogre::ColourValue MISSING_COLORS{0.6f, 0.6f, 0.6f, 1.0f};
const QColor FACES_COLOR(0, 255, 0), AUTOMATIC_FACES_COLOR(179, 179, 179);

QString serviceDescription(const char* of_what)
{
  return QString(
             "Asked for %1 that no topic brings. A name without a slash in front is looked for "
             "beside the geometry topic, in the namespaces above it and in that of RViz.")
      .arg(of_what);
}

}  // namespace

MeshProperties::MeshProperties(rviz::Property* parent) : QObject(parent)
{
  const PropertyMaker sources(this, [this] { Q_EMIT sourceChanged(); });
  const PropertyMaker contents(this, [this] { Q_EMIT contentChanged(); });
  const PropertyMaker styles(this, [this] { Q_EMIT styleChanged(); });
  geometry_topic_ = source_.bind(
      sources.topic<mesh_msgs::MeshGeometryStamped>("Geometry Topic", "The mesh.", parent),
      &MeshSource::geometry_topic);
  buffer_size_ = new rviz::IntProperty("Buffer Size", 1,
                                       "So many meshes (by their uuid) are shown, the newest ones.",
                                       parent, SIGNAL(contentChanged()), this);
  buffer_size_->setMin(1);
  display_type_ =
      new rviz::EnumProperty("Display Type", "Fixed Color",
                             "What the faces are colored by. Automatic: textures, else vertex "
                             "colors, else costs (unless all are 0), else heights, "
                             "whichever the map has.",
                             parent, SLOT(onDisplayType()), this);
  addFaces(sources, styles, display_type_);
  addTextures(sources, styles, display_type_);
  costs_ = new CostProperties(display_type_);
  contour_interval_ =
      styles.number("Contour Interval", 0.5f, "Meters from one line to the next higher one.",
                    display_type_, 1e-3f);
  update_rate_ = new rviz::FloatProperty("Visualization Update Rate", 10.0f,
                                         "How often updates of costs become seen, in Hz; "
                                         "those that come in between are put together.",
                                         display_type_);
  update_rate_->setMin(1.0f);
  alpha_ = style_.bind(styles.alpha("Alpha", "faces", display_type_), &MeshStyle::alpha);
  addSection(contents, parent);
  addLook(styles, parent);
  show_labels_ = contents.group("Show Labels", false,
                                "Draw labelled faces in the color of their label.", parent);
  labels_topic_ = source_.bind(sources.topic<mesh_msgs::MeshFaceCluster>(
                                   "Labels Topic", "Labels as they change.", show_labels_),
                               &MeshSource::labels_topic);
  labels_alpha_ = contents.alpha("Labels Alpha", "labelled faces", show_labels_);
  connect(costs_, SIGNAL(topicsChanged()), SIGNAL(sourceChanged()));
  connect(costs_, SIGNAL(coloringChanged()), SLOT(onColoring()));
  connect(costs_, SIGNAL(legendChanged()), SIGNAL(styleChanged()));
  onDisplayType();
}

void MeshProperties::addFaces(const PropertyMaker& sources, const PropertyMaker& styles,
                              rviz::Property* parent)
{
  faces_color_ = style_.bind(
      styles.color("Faces Color", FACES_COLOR,
                   "Color of the faces; with textures: of those without a material.", parent),
      &MeshStyle::faces_color);
  faces_alpha_ = styles.alpha("Faces Alpha", "faces", parent);
  colors_topic_ = source_.bind(sources.topic<mesh_msgs::MeshVertexColorsStamped>(
                                   "Vertex Colors Topic", "The colors of the vertices.", parent),
                               &MeshSource::colors_topic);
  colors_service_ = services_.bind(sources.line("Vertex Color Service Name", "get_vertex_colors",
                                                serviceDescription("vertex colors"), parent),
                                   &ServiceNames::colors);
}

void MeshProperties::addTextures(const PropertyMaker& sources, const PropertyMaker& styles,
                                 rviz::Property* parent)
{
  only_textured_ = style_.bind(styles.box("Show textured faces only", false,
                                          "Leave out the faces that have no texture.", parent),
                               &MeshStyle::only_textured);
  materials_service_ = services_.bind(sources.line("Material Service Name", "get_materials",
                                                   serviceDescription("materials"), parent),
                                      &ServiceNames::materials);
  texture_service_ = services_.bind(
      sources.line("Texture Service Name", "get_texture", serviceDescription("textures"), parent),
      &ServiceNames::texture);
  materials_topic_ = source_.bind(
      sources.topic<mesh_msgs::MeshMaterialsStamped>(
          "Materials Topic", "The materials of the faces, where they are published.", parent),
      &MeshSource::materials_topic);
  textures_topic_ = source_.bind(
      sources.topic<mesh_msgs::MeshTexture>(
          "Textures Topic", "The images of the materials, where they are published.", parent),
      &MeshSource::textures_topic);
}

/// A box in the frame of the mesh; at first without limits.
void MeshProperties::addSection(const PropertyMaker& make, rviz::Property* parent)
{
  show_section_ = make.group("Section", false,
                             "Draw only what lies in a box, as one storey of a building: it alone "
                             "can be pointed at and selected. The status says how far the mesh "
                             "reaches.",
                             parent);
  const struct
  {
    const char* name;
    bool upper;
    std::size_t axis;
  } limits[] = {{"Min Height", false, 2}, {"Max Height", true, 2}, {"Min X", false, 0},
                {"Max X", true, 0},       {"Min Y", false, 1},     {"Max Y", true, 1}};
  constexpr float INF = std::numeric_limits<float>::infinity();
  for (const auto& limit : limits) {
    const float none = limit.upper ? INF : -INF;
    auto* number =
        make.number(limit.name, none,
                    "In meters, in the frame of the mesh (height is z); inf or -inf: no limit.",
                    show_section_, -INF, INF);
    number->setFloat(none);  // which was finite while it had the limits that RViz begins with
    section_.bind(number, [limit](Section& section) -> float& {
      return (limit.upper ? section.upper : section.lower)[limit.axis];
    });
  }
}

/// What is the same for all display types: lines, culling, shading, level of detail.
void MeshProperties::addLook(const PropertyMaker& make, rviz::Property* parent)
{
  show_wireframe_ = style_.bind(make.group("Show Wireframe", true, "Draw the edges.", parent),
                                &MeshStyle::show_wireframe);
  style_.bind(make.color("Wireframe Color", Qt::black, "Color of the edges.", show_wireframe_),
              &MeshStyle::wireframe_color);
  style_.bind(make.alpha("Wireframe Alpha", "edges", show_wireframe_),
              [](MeshStyle& style) -> float& { return style.wireframe_color.a; });
  show_normals_ = style_.bind(
      make.group("Show Normals", true, "Draw a line along the normal of each vertex.", parent),
      &MeshStyle::show_normals);
  style_.bind(
      make.color("Normals Color", QColor(255, 0, 255), "Color of the normals.", show_normals_),
      &MeshStyle::normals_color);
  style_.bind(make.alpha("Normals Alpha", "normals", show_normals_),
              [](MeshStyle& style) -> float& { return style.normals_color.a; });
  style_.bind(make.number("Normals Scaling Factor", 0.1f, "Length of the normals in meters.",
                          show_normals_),
              &MeshStyle::normals_length);
  style_.bind(make.choice("Culling Mode (HW)", "None",
                          "Which faces are left out: none; those that are wound clockwise as seen "
                          "from here (the backs of faces, for a look into closed rooms from "
                          "outside: Anticlockwise); or the others.",
                          parent, {"None", "Clockwise", "Anticlockwise"}),
              &MeshStyle::culling);
  style_.bind(make.choice("Shading", "Smooth",
                          "Light faces by the normals of their vertices, or each by its plane.",
                          parent, {"Smooth", "Flat"}),
              &MeshStyle::flat_shading);
  rviz::Property* detail =
      style_.bind(make.group("Level of Detail", true,
                             "Merge faces that are too small to be told apart from here.", parent),
                  &MeshStyle::level_of_detail);
  style_.bind(
      make.number("Detail in pixels", MeshStyle().detail_pixels,
                  "Faces smaller than this on the screen may be merged.", detail, 0.1f, 100.0f),
      &MeshStyle::detail_pixels);
}

void MeshProperties::onDisplayType()
{
  const DisplayType type = displayType();
  const bool colors = type == DisplayType::VERTEX_COLOR;
  const bool textures = type == DisplayType::TEXTURES;
  const bool costs = type == DisplayType::VERTEX_COSTS;
  const bool contours = type == DisplayType::CONTOUR_LINES;
  const bool heights = contours || type == DisplayType::HEIGHT;
  const bool own = !given_;
  const std::pair<rviz::Property*, bool> seen[] = {
      {faces_color_, type == DisplayType::FIXED_COLOR || textures},
      {faces_alpha_, type == DisplayType::FIXED_COLOR},
      {colors_topic_, colors && own},
      {colors_service_, colors && own},
      {only_textured_, textures},
      {materials_service_, textures && own},
      {texture_service_, textures && own},
      {materials_topic_, textures && own},
      {textures_topic_, textures && own},
      {update_rate_, costs},
      {contour_interval_, contours},
      {alpha_, colors || textures || costs || heights},
  };
  for (const auto& property : seen) {
    property.first->setHidden(!property.second);
  }
  using Seen = CostProperties::Seen;
  costs_->setSeen(costs ? Seen::ALL : heights ? Seen::SCALE : Seen::NONE);
  if (costs && !loading_) {
    costs_->chooseLayer();
  }
  offerTypes();  // the one before is offered no longer where it has no data
  Q_EMIT contentChanged();
}

void MeshProperties::offerTypes()
{
  const QString chosen = display_type_->getString();
  display_type_->clearOptions();
  for (const auto& type : DISPLAY_TYPES) {
    const int number = static_cast<int>(type.second);
    // A choice from a file stays and waits for its data.
    if (!given_ || available_[number] || chosen == type.first) {
      display_type_->addOption(type.first, number);
    }
  }
}

void MeshProperties::setAvailable(bool colors, bool materials, bool costs, bool costs_tell)
{
  const std::array<bool, 8> available{true, colors, materials, costs, true, true, true, true};
  if (available != available_ || costs_tell != costs_tell_) {
    const DisplayType before = displayType();
    available_ = available;
    costs_tell_ = costs_tell;
    if (displayType() == before) {
      offerTypes();
    } else {
      onDisplayType();
    }
  }
}

MeshSource MeshProperties::source() const
{
  if (given_) {
    return *given_;
  }
  MeshSource source = source_.get();
  source.costs_topic = costs_->costsTopic();
  source.updates_topic = costs_->updateTopic();
  source.face_costs_topic = costs_->faceCostsTopic();
  return source;
}

void MeshProperties::setSource(const MeshSource& source)
{
  given_ = source;
  given_->updates_topic = source.costs_topic.empty() ? "" : source.costs_topic + "/updates";
  geometry_topic_->hide();
  labels_topic_->hide();
  costs_->setTopicsHidden(true);
  buffer_size_->hide();
  onDisplayType();
  Q_EMIT sourceChanged();
}

MeshSources::Names MeshProperties::names() const
{
  const MeshSource source = this->source();
  MeshSources::Names names;
  names.topics[MeshMember::GEOMETRY] = source.geometry_topic;
  names.topics[MeshMember::COSTS] = source.costs_topic;
  names.topics[MeshMember::FACE_COSTS] = source.face_costs_topic;
  names.topics[MeshMember::UPDATES] = source.updates_topic;
  names.topics[MeshMember::COLORS] = source.colors_topic;
  names.topics[MeshMember::MATERIALS] = source.materials_topic;
  names.topics[MeshMember::TEXTURES] = source.textures_topic;
  names.topics[MeshMember::LABELS] = source.labels_topic;
  names.services = services_.get();
  names.services.geometry_topic = source.geometry_topic;
  names.services.service_namespace = source.service_namespace;
  return names;
}

void MeshProperties::proposeTopics(const QString& costs, const QString& colors)
{
  if (colors_topic_->getTopic().isEmpty()) {
    colors_topic_->setString(colors);
  }
  if (costs_->costsTopic().empty()) {
    costs_->setCostsTopic(costs);
  }
}

std::size_t MeshProperties::bufferSize() const
{
  return given_ ? 1 : static_cast<std::size_t>(std::max(1, buffer_size_->getInt()));
}

void MeshProperties::setAutomatic(bool automatic)
{
  costs_->forgetLayer();
  faces_color_->setColor(automatic ? AUTOMATIC_FACES_COLOR : FACES_COLOR);
  costs_->setScale(automatic ? ColorScale::VIRIDIS : ColorScale::RAINBOW);
  show_wireframe_->setBool(!automatic);
  show_normals_->setBool(!automatic);
  choose(automatic ? DisplayType::AUTOMATIC : DisplayType::FIXED_COLOR);
}

void MeshProperties::choose(DisplayType type)
{
  for (const auto& named : DISPLAY_TYPES) {
    if (named.second == type) {
      display_type_->setString(named.first);
    }
  }
}

/// Who changes how costs look wants to see them, whatever else comes.
void MeshProperties::onColoring()
{
  if (isAutomatic() && !loading_ && !costs_->isChoosing()) {
    choose(displayType());
  }
  Q_EMIT contentChanged();
}

DisplayType MeshProperties::displayType() const
{
  const DisplayType chosen = chosenType();
  if (chosen != DisplayType::AUTOMATIC) {
    return chosen;
  }
  for (DisplayType type :
       {DisplayType::TEXTURES, DisplayType::VERTEX_COLOR, DisplayType::VERTEX_COSTS}) {
    const bool tells = type != DisplayType::VERTEX_COSTS || costs_tell_;
    if (tells && available_[static_cast<std::size_t>(type)]) {
      return type;
    }
  }
  return DisplayType::HEIGHT;
}

DisplayType MeshProperties::chosenType() const
{
  const QString chosen = display_type_->getString();
  for (const auto& type : DISPLAY_TYPES) {
    if (chosen == type.first) {
      return type.second;
    }
  }
  return DisplayType::FIXED_COLOR;
}

Section MeshProperties::section() const
{
  return sectionShown() ? section_.get() : Section();
}

MeshStyle MeshProperties::style(bool at_hand) const
{
  MeshStyle style = style_.get();
  style.section = section();
  switch (displayType()) {
    case DisplayType::FIXED_COLOR:
      style.faces_color.a = faces_alpha_->getFloat();
      return style;
    case DisplayType::HIDE_FACES:
      style.faces = MeshStyle::Faces::HIDDEN;
      return style;
    case DisplayType::TEXTURES:
      style.faces = MeshStyle::Faces::TEXTURES;
      style.faces_color.a = style.alpha;
      break;
    case DisplayType::CONTOUR_LINES:
      style.contour_interval = contour_interval_->getFloat();
      style.faces = MeshStyle::Faces::VERTEX_COLORS;
      break;
    default:
      style.faces = MeshStyle::Faces::VERTEX_COLORS;
  }
  if (!at_hand) {
    style.faces = MeshStyle::Faces::FIXED_COLOR;
    style.faces_color = MISSING_COLORS;
  }
  return style;
}

void MeshProperties::loadOlderKeys(const rviz::Config& config)
{
  int size = 0;
  if (!config.mapGetInt("Buffer Size", &size) && config.mapGetInt("Mesh Buffer Size", &size)) {
    buffer_size_->setInt(size);
  }
}

}  // namespace rviz_mesh_plugin
