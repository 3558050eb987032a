#pragma once

#include <cstddef>
#include <cstdint>
#include <list>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "base/layer_info.h"
#include "base/mesh_data.h"
#include "incoming/reception.h"

namespace rviz_mesh_plugin {

/// What belongs to one geometry.
struct MeshAttributes
{
  std::string uuid;
  std::vector<CostLayerConstPtr> costs;  ///< of vertices and of faces
  ColorLayerConstPtr colors;
  MaterialsConstPtr materials;
  std::map<std::uint32_t, TextureImageConstPtr> textures;  ///< by index
  LabelClusters labels;
  /// What has come and did not fit, by type and whether it is of faces, and by index.
  std::set<std::pair<std::string, bool>> costs_left_out;
  std::set<std::uint32_t> textures_left_out;

  /// Whether a layer of that name has come, but did not fit.
  bool leftOut(const std::string& name) const;
  /// A layer by the name that costTypes() gave it; null where it is not there.
  CostLayerConstPtr cost(const std::string& name) const;
};

/// The newest meshes, and the attributes of these and of others, by uuid: what
/// arrives before its geometry waits here for it. GUI thread only.
class MeshStore
{
 public:
  /// Attributes are kept for this many meshes besides those shown, the last changed ones.
  static constexpr std::size_t MAX_WAITING = 8;

  /// So many are told of those that did not fit.
  static constexpr std::size_t MAX_LEFT_OUT = 4096;

  /// @param most bytes of cost layers, and of textures, of each mesh: the newest layers, and the
  /// textures of lowest index, but at least one
  explicit MeshStore(std::size_t most = MAX_ATTRIBUTE_BYTES) : most_(most) {}

  /// How many meshes are kept, at least 1.
  void setCapacity(std::size_t capacity);

  /// Replaces the mesh of that uuid, or else the oldest one.
  void addMesh(const MeshDataConstPtr& mesh);
  void addCosts(const CostLayerConstPtr& layer);
  void addColors(const ColorLayerConstPtr& layer);
  void addMaterials(const MaterialsConstPtr& materials);
  void addTexture(const TextureImageConstPtr& texture);
  void addLabels(const LabelSetConstPtr& labels);
  /// Replaces what is known of the layers, of whichever geometry.
  void setLayerInfos(const std::string& uuid, LayerInfos infos);

  /// Takes a layer of vertices in which updates have changed something; nothing where the layer
  /// itself is not there. @return whether it is
  bool changeCosts(const CostLayerConstPtr& layer);

  /// Forgets what has come on one topic; with materials also textures.
  void forget(MeshMember part);
  void clear();

  /// The newest first.
  const std::vector<MeshDataConstPtr>& meshes() const { return meshes_; }
  /// Null where there is none.
  MeshDataConstPtr newest() const { return meshes_.empty() ? nullptr : meshes_.front(); }
  MeshDataConstPtr mesh(const std::string& uuid) const;

  /// Of one geometry; without anything in it where nothing has arrived.
  const MeshAttributes& attributes(const std::string& uuid) const;
  const MeshAttributes& attributes() const;  ///< of the newest mesh

  /// What the values of a layer of a geometry mean; what holds of all where nothing was said.
  const LayerInfo& layerInfo(const std::string& uuid, const std::string& layer) const;

  /// Names of the cost layers of the meshes shown, in order of their first
  /// arrival. That of a face layer whose type is also one of a vertex layer
  /// ends with " (faces)".
  std::vector<std::string> costTypes() const;

  /// What waits for another geometry than those shown.
  struct Waiting
  {
    std::size_t count = 0;
    std::string uuid;  ///< of the geometry of the one that changed last
  };
  Waiting waitingCosts() const;
  Waiting waitingColors() const;
  Waiting waitingLabels() const;

 private:
  MeshAttributes& attributesOf(const std::string& uuid);
  template <class Count>
  Waiting waiting(const Count& count) const;
  bool shown(const std::string& uuid) const { return mesh(uuid) != nullptr; }

  const std::size_t most_;
  std::size_t capacity_ = 1;
  std::vector<MeshDataConstPtr> meshes_;
  std::list<MeshAttributes> attributes_;  ///< the last changed first
  std::string infos_uuid_;
  LayerInfos infos_;
};

}  // namespace rviz_mesh_plugin
