#pragma once

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
#include "base/section.h"
#include "base/status_lines.h"
#include "incoming/reception.h"
#include "labels/face_parents.h"
#include "labels/label_colors.h"
#include "labels/label_faces.h"
#include "labels/shown_labels.h"
#include "rendering/placed_visual.h"
#include "sources/face_parents_source.h"
#include "sources/label_client.h"
#include "sources/label_color_source.h"
#include "sources/mesh_source.h"
#include "sources/mesh_sources.h"
#endif

namespace rviz_mesh_plugin {

class LabelNames;
class LabelOverlay;
class LabelProperties;

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
  /// Where they come from.
  MeshSource source() const;

  /// The mesh that is labelled; null before it has arrived.
  MeshDataConstPtr mesh() const { return store_.mesh(); }

  /// All labels of the mesh as they are now.
  const LabelClusters& labels() const { return store_.labels(); }
  /// Whether there are no others: those who store them have said what there is.
  bool labelsComplete() const { return store_.isComplete(); }
  /// Has those who store them say so once more: a message of theirs may be lost.
  void askForLabels();

  /// As it is drawn: the label's own, else that of its class.
  Rgba8 labelColor(const std::string& label) { return colors_.color(label); }
  /// The label's own; nothing where it has none, or none is known yet.
  std::optional<Rgba8> ownColor(const std::string& label) const;

  /// How labels are drawn; also those that are gone.
  const LabelLooks& looks() const;
  /// Shows its class, too.
  void setShown(const std::string& label, bool shown);

  /// What of a parent the faces of the mesh are parts of; null where it was made of none, or that
  /// is not known.
  FaceParentsConstPtr faceParents() const;

  /// Labels whose name is in the picture.
  std::vector<std::string> drawnNames() const;

  /// In meters.
  float brushSize() const;

  /// Asks the owner of the labels to store a label with these faces, instead of those it has
  /// (@a override) or beside them: it shows once it is stored. Returns why that cannot be asked
  /// for, else an empty string.
  std::string storeFaces(const std::string& label, const LabelFacesConstPtr& faces, bool override);

  /// The same for a color of the label's own; null: that of its class again.
  std::string setLabelColor(const std::string& label, const Rgba8* color);

  /// What is said of the edits that are on their way, by who follows them until they are stored.
  void showEdits(const OptionalStatus& status) { edits_ = status; }

  void setTopic(const QString& topic, const QString& datatype) override;
  void update(float wall_dt, float ros_dt) override;
  void reset() override;

 protected:
  void onInitialize() override;
  void onEnable() override;
  void onDisable() override;

 private:
  void onLook();
  void onVisibility();
  void onColorChosen(const QString& label, const QColor& color);
  void work();
  void subscribe();
  void unsubscribe();
  void restart();
  void takeMessages();
  void takeLabels(bool answered = true);
  void askAnew();
  void takeColors();
  void applyChanges();
  void applyLook(const std::string& label);
  void updatePose();
  void updateNames(const std::optional<FramePose>& pose, const Section& section);
  void updateStatuses();
  StatusLine geometryStatus() const;
  OptionalStatus labelsStatus() const;
  std::string whyNotEditable(const std::string& label) const;

  LabelProperties* properties_;
  MeshSources sources_{false};
  LabelClient owner_;
  LabelColorSource label_colors_;
  FaceParentsSource face_parents_;
  ShownLabels store_;
  LabelColors colors_;
  StatusLines lines_;
  std::unique_ptr<LabelOverlay> overlay_;
  std::unique_ptr<LabelNames> label_names_;  ///< null: not to be drawn
  HiddenFacesConstPtr hidden_faces_;         ///< of the mesh, as they were last
  bool renamed_ = true;  ///< labels, or how they are drawn, since these have been told
  std::optional<MeshSource> source_;
  std::string subscription_error_;
  MeshLoader::Content received_;  ///< the newest mesh, and what is being done on it
  Reception labels_received_;
  std::set<std::string> to_show_;  ///< labels whose faces the overlay does not have yet
  std::map<std::string, std::size_t> classes_;
  std::vector<std::string> names_;  ///< that the properties have been told
  std::size_t hidden_ = 0;          ///< labels
  bool recount_ = true;             ///< these
  bool ask_again_ = false;          ///< for all labels, once they have come
  bool asked_for_parents_ = false;  ///< of the mesh, since it was subscribed to
  OptionalStatus edits_;
  std::string edit_failure_;
};

}  // namespace rviz_mesh_plugin
