#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#ifndef Q_MOC_RUN
#include <mesh_msgs/LayerInfoArray.h>
#include <rviz/display.h>
#include <std_msgs/String.h>

#include "base/mesh_data.h"
#include "base/section.h"
#include "base/status_lines.h"
#include "displays/mesh_report.h"
#include "displays/mesh_requests.h"
#include "incoming/attribute_queue.h"
#include "incoming/mesh_store.h"
#include "legend/legend.h"
#include "mesh_view/mesh_appearance.h"
#include "mesh_view/shown_mesh.h"
#include "ros_client/topic_directory.h"
#include "sources/label_color_source.h"
#include "sources/map_topic.h"
#include "sources/mesh_source.h"
#include "sources/mesh_sources.h"
#endif

namespace rviz_mesh_plugin {

class MeshProperties;
class MeshVisual;

/// Updates of costs that have been stored, but are not seen yet: those that come in quick
/// succession become seen together. GUI thread only.
class PendingCosts
{
 public:
  using Clock = std::chrono::steady_clock;

  void take(const std::vector<ChangedCosts>& costs, MeshStore& store);

  /// @param rate in Hz: how often at most
  /// @return whether something has become seen
  bool show(Clock::time_point now, float rate, MeshAppearances& appearances);

  void clear() { changed_.clear(); }

 private:
  using Layer = std::pair<std::string, std::string>;  ///< uuid and type
  struct Changed
  {
    CostLayerConstPtr layer;
    bool all = false;  ///< of the vertices
    std::vector<std::uint32_t> vertices;
  };

  std::map<Layer, Changed> changed_;
  Clock::time_point shown_;
};

/// Shows the newest meshes of a mesh_msgs/MeshGeometryStamped topic, or of a
/// service, in one color, in the colors of their vertices, with their textures,
/// or by a cost layer.
///
/// Everything that takes long is done elsewhere: update() takes the results
/// over and uploads them in slices. Disabling hides and unsubscribes; data stay
/// until reset(). One status line per concern: Topic, Geometry, Costs, Colors,
/// Textures, Section, Hidden, Transform, Labels, Services, Map.
class TexturedMeshDisplay : public rviz::Display
{
  Q_OBJECT

 public:
  TexturedMeshDisplay();

  /// Shows what this source has from now on; the properties for topics and
  /// services are hidden.
  void setSource(const MeshSource& source);
  /// Begins as rviz_map_plugin/Mesh does, not with the best that the map has.
  void beginAsReleased();

  /// The newest mesh that is shown; null where there is none.
  MeshDataConstPtr mesh() const;

  /// The meshes that can be seen (and so be clicked at), the newest first.
  std::vector<ShownMesh> shownMeshes() const;

  /// Whether this is one of its meshes, shown or not.
  bool has(const MeshDataConstPtr& mesh) const;

  /// Its mesh of this name, shown or not; null where it draws none.
  MeshDataConstPtr drawn(const std::string& uuid) const;

  /// What is seen of its meshes, in their coordinates.
  Section section() const;

  /// Costs, colors and labels of a mesh, as far as they have arrived.
  const MeshAttributes& attributes(const MeshData& mesh) const
  {
    return store_.attributes(mesh.uuid);
  }

  /// What the costs of a layer of a mesh mean.
  const LayerInfo& layerInfo(const MeshData& mesh, const std::string& layer) const
  {
    return store_.layerInfo(mesh.uuid, layer);
  }

  /// The cost layers that can be chosen, in this order; some of them may not have arrived.
  const std::vector<std::string>& costTypes() const { return cost_types_; }

  /// What draws the newest mesh; null without one.
  const MeshVisual* visual() const;

  void setTopic(const QString& topic, const QString& datatype) override;
  void load(const rviz::Config& config) override;
  void update(float wall_dt, float ros_dt) override;
  void reset() override;

 protected:
  void onInitialize() override;
  void onEnable() override;
  void onDisable() override;

 private Q_SLOTS:
  void onSource();
  void onContent();

 private:
  using Clock = std::chrono::steady_clock;

  void work();
  void takeMessages();
  void offerChoices();
  void followLabelColors();
  void updatePoses();
  void updateLegend();
  void upload(Clock::time_point end);

  MeshProperties* properties_;
  MeshStore store_;
  MeshSources sources_;
  MeshRequests requests_;
  LabelColorSource label_colors_;
  MapTopic<std_msgs::String> remark_{"remark"};
  MapTopic<mesh_msgs::LayerInfoArray> layer_info_{"layer_info"};
  mesh_msgs::LayerInfoArrayConstPtr shown_info_;  ///< that is in the store
  std::unique_ptr<MeshAppearances> appearances_;
  std::unique_ptr<MeshReport> report_;
  Legend legend_;
  StatusLines lines_;
  QueuedAttributes received_;  ///< for its receptions
  std::string working_;        ///< what the loader is doing
  PendingCosts pending_costs_;
  TopicDirectory directory_;
  std::vector<std::string> cost_types_;  ///< that are offered
  std::string costs_tell_of_;            ///< uuid of the mesh
  bool costs_tell_ = false;              ///< there were some of which not all were free
  std::uint64_t hidden_revision_ = 0;
  bool source_changed_ = false;
  bool content_changed_ = false;
  bool uploading_ = false;
};

}  // namespace rviz_mesh_plugin
