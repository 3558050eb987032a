#pragma once

#include <initializer_list>
#include <string>

#include "base/status_lines.h"
#include "incoming/mesh_inbox.h"
#include "mesh_view/mesh_status.h"
#include "ros_client/topic_directory.h"
#include "sources/mesh_feed.h"

namespace rviz_mesh_plugin {

class Legend;
class MeshPainters;
class MeshProperties;
class MeshStore;

/// Puts together what the status tree of a mesh display says.
class MeshReport
{
 public:
  MeshReport(const MeshFeed& feed, const MeshProperties& properties, const MeshStore& store,
             const MeshPainters& painters, const Legend& legend, TopicDirectory& directory)
      : feed_(feed),
        properties_(properties),
        store_(store),
        painters_(painters),
        legend_(legend),
        directory_(directory)
  {
  }

  /// @param inbox for the receptions
  /// @param working what the loader is doing
  void report(const InboxContent& inbox, const std::string& working, StatusLines& lines);

 private:
  void findSilentTopics(const InboxContent& inbox);
  StatusLine topic(const Reception& geometry) const;
  /// Why nothing comes from a topic; else empty.
  std::string problem(MeshNews part) const;
  GeometryState geometry(const Reception& reception, const std::string& working) const;
  /// What is the same for all attributes. @param parts that bring them
  template <class State>
  State attribute(bool chosen, const Reception& reception,
                  std::initializer_list<MeshNews> parts) const;
  CostsState costs(const InboxContent& inbox) const;
  ColorsState colors(const InboxContent& inbox) const;
  TexturesState textures(const InboxContent& inbox) const;
  LabelsState labels(const InboxContent& inbox) const;
  OptionalStatus services() const;

  const MeshFeed& feed_;
  const MeshProperties& properties_;
  const MeshStore& store_;
  const MeshPainters& painters_;
  const Legend& legend_;
  TopicDirectory& directory_;
};

}  // namespace rviz_mesh_plugin
