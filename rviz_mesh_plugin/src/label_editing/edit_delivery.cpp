#include "label_editing/edit_delivery.h"

#include <algorithm>
#include <cstdint>
#include <vector>

#include <ros/names.h>

#include "labels/face_parents.h"
#include "labels/label_faces.h"
#include "sources/label_color_source.h"

namespace rviz_mesh_plugin {
namespace {

/// As released; label_manager listens there, and leaves labels of a map that a server has to that.
/// Not latched: an old edit that is heard again would undo newer ones.
const char* const EVERYBODY = "/cluster_label";
constexpr std::uint32_t QUEUE = 100;

/// Faces as they come back when they are stored: where the mesh was made of another one, with all
/// parts of a face of that.
std::vector<std::uint32_t> asStored(const std::vector<std::uint32_t>& faces,
                                    const ClusterLabelDisplay& display)
{
  const FaceParentsConstPtr parents = display.faceParents();
  return parents ? wholeFaces(faces, *parents) : faces;
}

}  // namespace

EditDelivery::EditDelivery()
{
  everybody_.advertise(node_, EVERYBODY, QUEUE);
}

std::string EditDelivery::send(const LabelEdit& edit, ClusterLabelDisplay& display)
{
  if (!edit.faces) {
    return display.setLabelColor(edit.label, edit.color ? &*edit.color : nullptr);
  }
  if (edit.hasChanged(facesOf(display.labels(), edit.label))) {
    return "it has changed meanwhile, elsewhere, and what is new would be lost: give up and look "
           "at it, or delete it";
  }
  other_.erase({edit.mesh, edit.label});
  const std::string reason = display.storeFaces(edit.label, edit.faces, !edit.adds);
  // Not where the UUID says "the only one": that may be another mesh for who hears it. Nor that a
  // label has gone: its owner deletes it, and no faces would be a label without faces elsewhere.
  const bool removes = edit.faces->empty() && !edit.adds;
  const std::string& uuid = edit.mesh.first;
  if (reason.empty() && !removes && !uuid.empty() && uuid != "mesh" &&
      ros::names::append(labelNamespace(display.source()), "cluster_label") != EVERYBODY) {
    everybody_.publish(
        sentEdit(*display.mesh(), edit.label, edit.faces, !edit.adds, display.faceParents()));
  }
  return reason;
}

/// A label that has been compared and is another one is not compared again, as it may be large.
bool EditDelivery::isStored(const LabelEdit& edit, const ClusterLabelDisplay& display)
{
  if (!edit.faces) {
    return display.ownColor(edit.label) == edit.color;
  }
  const auto label = display.labels().find(edit.label);
  const LabelClusterConstPtr now = label == display.labels().end() ? nullptr : label->second;
  const auto compared = other_.find({edit.mesh, edit.label});
  if (compared != other_.end() && compared->second == now) {
    return false;
  }
  const LabelFacesConstPtr stored = facesOf(display.labels(), edit.label);
  const bool is_stored =
      edit.adds
          ? std::includes(stored->begin(), stored->end(), edit.faces->begin(), edit.faces->end())
          : *stored == *edit.faces || *stored == asStored(*edit.faces, display);
  if (is_stored) {
    other_.erase({edit.mesh, edit.label});
  } else {
    other_[{edit.mesh, edit.label}] = now;
  }
  return is_stored;
}

}  // namespace rviz_mesh_plugin
