#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#ifndef Q_MOC_RUN
#include <rviz/display.h>

#include "base/mesh_data.h"
#include "base/status_lines.h"
#include "incoming/mesh_inbox.h"
#include "incoming/mesh_loader.h"
#include "incoming/reception.h"
#include "labels/label_colors.h"
#include "labels/label_store.h"
#include "sources/label_color_feed.h"
#include "sources/label_owner.h"
#include "sources/mesh_services.h"
#include "sources/mesh_source.h"
#include "sources/mesh_topics.h"
#endif

namespace rviz_mesh_plugin {

class LabelOverlay;
class LabelProperties;

/// What the status lines of a display of labels are made of.
struct LabelDisplayState
{
  bool source_given = false;  ///< another display decides what is shown
  std::string geometry_topic;
  std::string labels_topic;
  std::string subscription_error;
  Reception geometry;
  Reception labels;
  std::string working;  ///< on the mesh
  std::size_t label_count = 0;
  std::size_t class_count = 0;
  std::size_t hidden = 0;   ///< labels
  std::size_t to_show = 0;  ///< labels that are being uploaded
};

/// Shows the labelled clusters of a mesh, and gives others (tools, panels) what they need to change
/// them. As a child of Map3D its source is set; on its own it has properties for that.
///
/// Status lines: Geometry, Labels, Label colors, Services, Transform, Edits; Display, where
/// something went wrong.
class ClusterLabelDisplay : public rviz::Display
{
  Q_OBJECT

 public:
  ClusterLabelDisplay();
  ~ClusterLabelDisplay() override;

  /// From now on mesh and labels come from there, and the properties for topics are hidden.
  void setSource(const MeshSource& source);

  /// The mesh that is labelled; null before it has arrived.
  MeshDataConstPtr mesh() const { return store_.mesh(); }

  /// All labels of the mesh as they are now.
  const LabelClusters& labels() const { return store_.labels(); }
  /// Whether there are no others: those who store them have said what there is.
  bool labelsComplete() const { return store_.isComplete(); }

  /// As it is drawn: the label's own, else that of its class.
  Rgba8 labelColor(const std::string& label) { return colors_.color(label); }
  /// Null while they are not known.
  OwnColorsConstPtr ownColors() const
  {
    return mesh() ? label_colors_.colors(mesh()->uuid) : nullptr;
  }

  /// The label that is chosen to be edited; empty for a new one ("__NEW__").
  std::string activeLabel() const;
  void setActiveLabel(const std::string& label);

  /// In meters.
  float brushSize() const;

  /// Asks the owner of the labels to store a label with these faces and no others: it shows once it
  /// is stored. Returns why that cannot be asked for, else an empty string.
  std::string setLabelFaces(const std::string& label, const std::vector<std::uint32_t>& faces);
  /// The same for these faces and those that it has.
  std::string addLabelFaces(const std::string& label, const std::vector<std::uint32_t>& faces);

  /// The same for a color of the label's own; null: that of its class again.
  std::string setLabelColor(const std::string& label, const Rgba8* color);

  void setTopic(const QString& topic, const QString& datatype) override;
  void update(float wall_dt, float ros_dt) override;
  void reset() override;

 protected:
  void onInitialize() override;
  void onEnable() override;
  void onDisable() override;

 private Q_SLOTS:
  void onTopics();
  void onLook();
  void onLabelVisibility(const QString& label);
  void onClassVisibility(const QString& label_class);
  void onColorChosen(const QString& label);

 private:
  using Clock = std::chrono::steady_clock;

  MeshSource source() const;
  void work();
  void subscribe();
  void unsubscribe();
  void restart();
  void takeMessages();
  void takeColors();
  void applyChanges();
  void applyLook(const std::string& label);
  void updatePose();
  void updateStatuses();
  std::string whyNotEditable(const std::string& label) const;
  std::string storeFaces(const std::string& label, const std::vector<std::uint32_t>& faces,
                         bool override);

  LabelProperties* properties_;
  std::shared_ptr<MeshInbox> inbox_;
  std::shared_ptr<MeshLoader> loader_;
  MeshTopics topics_;
  MeshServices services_;
  LabelOwner owner_;
  LabelColorFeed label_colors_;
  LabelStore store_;
  LabelColors colors_;
  StatusLines lines_;
  std::unique_ptr<LabelOverlay> overlay_;
  std::optional<MeshSource> source_;
  LabelDisplayState state_;
  std::set<std::string> to_show_;  ///< labels whose faces the overlay does not have yet
  std::map<std::string, std::size_t> classes_;
  std::vector<std::string> names_;                  ///< that the properties have been told
  bool recount_ = true;                             ///< the hidden labels
  std::map<std::string, Clock::time_point> edits_;  ///< labels that were sent to be stored
  std::string edit_failure_;
  bool work_failed_ = false;
};

}  // namespace rviz_mesh_plugin
