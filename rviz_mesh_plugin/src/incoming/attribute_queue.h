#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include <mesh_msgs/MeshFaceCluster.h>
#include <mesh_msgs/MeshFaceCostsStamped.h>
#include <mesh_msgs/MeshMaterialsStamped.h>
#include <mesh_msgs/MeshTexture.h>
#include <mesh_msgs/MeshVertexColorsStamped.h>
#include <mesh_msgs/MeshVertexCostsSparseStamped.h>
#include <mesh_msgs/MeshVertexCostsStamped.h>

#include "base/mesh_data.h"
#include "incoming/cost_order.h"
#include "incoming/reception.h"

namespace rviz_mesh_plugin {

/// A layer of vertices in which updates have changed something since it was handed over last.
struct ChangedCosts
{
  CostLayerConstPtr layer;                  ///< with them; nobody changes it any more
  std::vector<CostUpdateConstPtr> updates;  ///< which vertices; none: so many that all count
  std::size_t values = 0;                   ///< in them
};

/// What the GUI thread takes from the queue: the newest of each kind, and the receptions so far.
/// All lists are in order of arrival.
struct QueuedAttributes
{
  std::vector<CostLayerConstPtr> costs;        ///< one per uuid, type and kind (vertices, faces)
  std::vector<ChangedCosts> changed_costs;     ///< one per uuid and type, newer than costs
  std::size_t stale = 0;                       ///< updates left out, in all
  std::vector<ColorLayerConstPtr> colors;      ///< one per uuid
  std::vector<MaterialsConstPtr> materials;    ///< one per uuid
  std::vector<TextureImageConstPtr> textures;  ///< one per uuid and index
  std::vector<LabelSetConstPtr> labels;        ///< to be applied in this order
  PerMember<Reception> receptions;             ///< but of the geometry, which has a loader
};

/// Between the threads that ROS and services call back and the GUI thread: checks and converts
/// messages on the former, hands the newest over to the latter, so that a fast publisher can
/// neither block RViz nor fill its memory. Updates of costs are merged into their layer there, too:
/// in a copy that is made once each time the GUI thread has taken the one before. Thread safe.
///
/// What may be too late is received with a flag in its origin: where that is set at the end of the
/// conversion, the message is dropped without a trace.
class AttributeQueue
{
 public:
  /// @param most bytes of layers, and of textures, that are kept while nobody takes them: the
  /// oldest go, but not the newest one
  explicit AttributeQueue(std::size_t most = MAX_ATTRIBUTE_BYTES) : most_(most) {}

  /// All these return whether the message was accepted; if not, its reception says why.
  bool receive(const mesh_msgs::MeshVertexCostsStamped& message, const Origin& origin = {});
  bool receive(const mesh_msgs::MeshFaceCostsStamped& message, const Origin& origin = {});
  bool receive(const mesh_msgs::MeshVertexCostsSparseStamped& message, const Origin& origin = {});
  bool receive(const mesh_msgs::MeshVertexColorsStamped& message, const Origin& origin = {});
  bool receive(const mesh_msgs::MeshMaterialsStamped& message, const Origin& origin = {});
  bool receive(const mesh_msgs::MeshTexture& message, const Origin& origin = {});
  /// One label of the only mesh, as it is now.
  bool receive(const mesh_msgs::MeshFaceCluster& message, const Origin& origin = {});
  /// @param all these are all labels of the mesh
  bool receiveLabels(const std::string& uuid,
                     const std::vector<mesh_msgs::MeshFaceCluster>& clusters, bool all,
                     const Origin& origin = {});

  /// Counts a message that could not even be read.
  void refuse(MeshMember part, const std::string& reason, const Origin& origin = {});

  /// Hands over and forgets what has arrived; the receptions go on counting. Never waits for a
  /// message that is being converted, or joined with others.
  QueuedAttributes take();

  /// Forgets what has arrived on one topic, and its reception; with materials also textures.
  void forget(MeshMember part);

 private:
  template <class Convert, class Arrange, class Store>
  bool accept(MeshMember part, const Convert& convert, const Arrange& arrange, const Store& store,
              const Origin& origin);
  template <class Message, class Store>
  bool accept(MeshMember part, const Message& message, const Store& store, const Origin& origin);
  /// Of order and layers, what forget() has asked for; where changing_ is held.
  void forgetOrder();
  /// @param edit is given a copy, maybe more than once: what the GUI thread has left of it
  template <class Edit>
  bool change(const Edit& edit, const Origin& origin);

  std::string merge(const CostUpdateConstPtr& update);
  void endMerging(bool kept);

  const std::size_t most_;
  std::mutex changing_;  ///< by one thread at a time, which may take long
  CostOrder order_;
  /// The newest layers of vertices, by uuid and type, as long as they are in use.
  std::map<std::pair<std::string, std::string>, std::weak_ptr<CostLayer>> layers_;
  std::shared_ptr<CostLayer> coming_;  ///< whole; not known before it is kept
  ChangedCosts merging_;  ///< taken out of the content, so that nobody else has its layer
  std::mutex mutex_;      ///< for a moment
  QueuedAttributes content_;
  bool layers_forgotten_ = false;  ///< by the GUI thread, which does not wait for changing_
  bool updates_forgotten_ = false;
  std::uint64_t version_ = 0;  ///< counts what the GUI thread has taken or forgotten
};

}  // namespace rviz_mesh_plugin
