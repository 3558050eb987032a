#pragma once

#include <cstddef>
#include <cstdint>
#include <list>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "base/mesh_data.h"

namespace rviz_mesh_plugin {

/// A layer of costs with what updates have changed in it.
class StoredCosts
{
 public:
  explicit StoredCosts(CostLayerConstPtr layer);

  /// The same pointer from the first update on.
  const CostLayerConstPtr& layer() const { return layer_; }

  /// By an entire layer, but for values that newer updates have brought.
  void replace(const CostLayerConstPtr& layer);

  enum class Outcome
  {
    CHANGED,
    STALE,  ///< all that the update names is newer
    MISFIT  ///< nothing is changed
  };
  /// Changes the values that the update names and that are not newer.
  /// @param problem why it does not fit, or empty
  Outcome apply(const CostUpdateConstPtr& update, std::string& problem);

 private:
  std::uint64_t stampOf(std::uint32_t vertex) const;
  CostUpdateConstPtr newerThan(const CostLayer& layer) const;

  CostLayerConstPtr layer_;
  /// The same, once it has been updated: a copy that nobody else reads in another thread.
  std::shared_ptr<CostLayer> own_;
  /// Of each vertex, that of its newest update; empty where none had one.
  std::vector<std::uint64_t> stamps_;
  std::uint64_t newest_stamp_ = 0;
};

/// What belongs to one geometry.
struct MeshAttributes
{
  std::string uuid;
  std::vector<StoredCosts> costs;  ///< of vertices and of faces
  ColorLayerConstPtr colors;
  MaterialsConstPtr materials;
  std::map<std::uint32_t, TextureImageConstPtr> textures;  ///< by index
  LabelClusters labels;

  /// A layer by the name that costTypes() gave it; null where it is not there.
  CostLayerConstPtr cost(const std::string& name) const;
};

/// The newest meshes, and the attributes of these and of others, by uuid: what
/// arrives before its geometry waits here for it. GUI thread only.
class MeshStore
{
 public:
  /// Attributes are kept for this many meshes besides those shown, the last
  /// changed ones; of each this many cost layers, and this many values of
  /// updates that wait for their layer.
  static constexpr std::size_t MAX_WAITING = 8;
  static constexpr std::size_t MAX_LAYERS = 256;
  static constexpr std::size_t MAX_WAITING_VALUES = 1000000;
  static constexpr std::size_t MAX_WAITING_UPDATES = 10000;  ///< however small
  static constexpr std::size_t MAX_TEXTURES = 4096;          ///< of each, those of lower index

  /// How many meshes are kept, at least 1.
  void setCapacity(std::size_t capacity);

  /// Replaces the mesh of that uuid, or else the oldest one.
  void addMesh(const MeshDataConstPtr& mesh);
  /// Replaces the layer but for values that newer updates have brought.
  void addCosts(const CostLayerConstPtr& layer);
  void addColors(const ColorLayerConstPtr& layer);
  void addMaterials(const MaterialsConstPtr& materials);
  void addTexture(const TextureImageConstPtr& texture);
  void addLabels(const LabelSetConstPtr& labels);

  /// Changes the values that the update names, and that are not newer. Of a layer that is not there
  /// it waits for it; where it does not fit, nothing changes.
  /// @return the layer that has changed, the same pointer as before from the
  /// second time on; null
  ///   where none has
  CostLayerConstPtr update(const CostUpdateConstPtr& update);

  /// Why the newest update could not be applied; empty if it could.
  const std::string& updateProblem() const { return update_problem_; }
  /// How many updates were left out, because all they name was newer.
  std::size_t staleUpdates() const { return stale_updates_; }
  /// How many values of updates wait for their layer.
  std::size_t waitingValues() const { return waiting_values_; }

  void clearMeshes() { meshes_.clear(); }
  void clearCosts(bool on_faces);
  void clearUpdates();  ///< that wait for their layer
  void clearColors();
  void clearMaterials();  ///< and textures
  void clearLabels();
  void clear();

  /// The newest first.
  const std::vector<MeshDataConstPtr>& meshes() const { return meshes_; }
  /// Null where there is none.
  MeshDataConstPtr newest() const { return meshes_.empty() ? nullptr : meshes_.front(); }
  MeshDataConstPtr mesh(const std::string& uuid) const;

  /// Of one geometry; without anything in it where nothing has arrived.
  const MeshAttributes& attributes(const std::string& uuid) const;
  const MeshAttributes& attributes() const;  ///< of the newest mesh

  /// Names of the cost layers of the meshes shown, in order of their first
  /// arrival. That of a face layer whose type is also one of a vertex layer
  /// ends with " (faces)".
  std::vector<std::string> costTypes() const;

  /// How many of these wait for another geometry than those shown.
  std::size_t waitingCosts() const;
  std::size_t waitingColors() const;

 private:
  MeshAttributes& attributesOf(const std::string& uuid);
  bool shown(const std::string& uuid) const { return mesh(uuid) != nullptr; }
  CostLayerConstPtr apply(StoredCosts& costs, const CostUpdateConstPtr& update);
  void applyWaiting(StoredCosts& costs);
  void keepWaiting(const CostUpdateConstPtr& update);

  std::size_t capacity_ = 1;
  std::vector<MeshDataConstPtr> meshes_;
  std::list<MeshAttributes> attributes_;  ///< the last changed first
  std::list<CostUpdateConstPtr> waiting_updates_;
  std::size_t waiting_values_ = 0;
  std::string update_problem_;
  std::size_t stale_updates_ = 0;
};

}  // namespace rviz_mesh_plugin
