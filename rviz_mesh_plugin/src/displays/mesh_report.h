#pragma once

#include <initializer_list>
#include <string>

#include "base/status_lines.h"
#include "incoming/attribute_queue.h"
#include "mesh_view/mesh_status.h"
#include "mesh_view/seen_faces.h"
#include "ros_client/topic_directory.h"
#include "sources/mesh_sources.h"

namespace rviz_mesh_plugin {

class Legend;
class MeshAppearances;
class MeshProperties;
class MeshStore;

/// Puts together what the status tree of a mesh display says.
class MeshReport
{
 public:
  MeshReport(const MeshSources& sources, const MeshProperties& properties, const MeshStore& store,
             const MeshAppearances& appearances, const Legend& legend, TopicDirectory& directory)
      : sources_(sources),
        properties_(properties),
        store_(store),
        appearances_(appearances),
        legend_(legend),
        directory_(directory)
  {
  }

  /// @param queue for the receptions
  /// @param working what the loader is doing
  void report(const QueuedAttributes& queue, const std::string& working, StatusLines& lines);

 private:
  void findSilentTopics(const QueuedAttributes& queue);
  void reportSeen(StatusLines& lines);
  StatusLine topic(const Reception& geometry) const;
  /// Why nothing comes from a topic; else empty.
  std::string problem(MeshMember part) const;
  GeometryState geometry(const Reception& reception, const std::string& working) const;
  /// What is the same for all attributes. @param parts that bring them
  template <class State>
  State attribute(bool chosen, const Reception& reception,
                  std::initializer_list<MeshMember> parts) const;
  CostsState costs(const QueuedAttributes& queue) const;
  ColorsState colors(const QueuedAttributes& queue) const;
  TexturesState textures(const QueuedAttributes& queue) const;
  LabelsState labels(const QueuedAttributes& queue) const;

  const MeshSources& sources_;
  const MeshProperties& properties_;
  const MeshStore& store_;
  const MeshAppearances& appearances_;
  const Legend& legend_;
  TopicDirectory& directory_;
  SeenFaces in_section_;
  SeenFaces seen_;  ///< there, and not hidden
};

}  // namespace rviz_mesh_plugin
