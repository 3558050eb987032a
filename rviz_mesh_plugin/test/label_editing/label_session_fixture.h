#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <rviz/visualization_manager.h>

#include "label_editing/label_session.h"
#include "labels/label_faces.h"
#include "support/label_display_fixture.h"
#include "support/label_fixture.h"

/// A session on a display with three labels.
class LabelSessionFixture : public LabelDisplayFixture
{
 protected:
  using Faces = rviz_mesh_plugin::LabelSession::Faces;

  void SetUp() override
  {
    LabelDisplayFixture::SetUp();
    everybody = node.subscribe<mesh_msgs::MeshFaceClusterStamped>(
        "/cluster_label", 100,
        [this](const auto& message) { copies.push_back(message->uuid + message->cluster.label); });
  }

  void TearDown() override
  {
    session.reset();
    LabelDisplayFixture::TearDown();
  }

  /// Stores tree_1 in row 0, tree_2 in row 1, wall_1 in row 2.
  void start(std::chrono::milliseconds patience = std::chrono::seconds(60), bool listen = true)
  {
    server->addLabel("tree_1", test_labels::rows(10, 0, 1));
    server->addLabel("tree_2", test_labels::rows(10, 1, 2));
    server->addLabel("wall_1", test_labels::rows(10, 2, 3));
    if (listen) {
      server->listen(name_space);
    }
    display = createLabels();
    publishMesh();
    ASSERT_TRUE(says(display, "Labels", "3 labels"));
    session = std::make_unique<rviz_mesh_plugin::LabelSession>(manager(), patience);
    ASSERT_TRUE(until([&] {
      return session->display() && everybody.getNumPublishers() > 0 &&
             server->labels.getNumSubscribers() > 0;
    }));
  }

  template <class Done>
  bool until(const Done& done)
  {
    return spinUntil([&] {
      session->work(nullptr);
      return done();
    });
  }

  /// Of who stores labels: what a label has after an edit.
  mesh_msgs::MeshFaceCluster after(const mesh_msgs::MeshFaceClusterStamped& edit) const
  {
    auto cluster = edit.cluster;
    const auto label = display->labels().find(cluster.label);
    if (!edit.override && label != display->labels().end()) {
      const Faces& stored = label->second->faces;
      cluster.face_indices.insert(cluster.face_indices.end(), stored.begin(), stored.end());
      rviz_mesh_plugin::sortFaces(cluster.face_indices);
    }
    return cluster;
  }

  /// Waits until so many edits have been received in all, and stores the last.
  testing::AssertionResult store(std::size_t count)
  {
    if (!until([&] { return server->edits().size() == count; })) {
      return testing::AssertionFailure() << server->edits().size() << " edits";
    }
    const auto cluster = after(server->edits().back());
    answered = count;
    return publish(cluster) ? testing::AssertionSuccess()
                            : testing::AssertionFailure() << "not shown";
  }

  /// Stores all edits in the order in which they come, and answers those not answered yet.
  testing::AssertionResult answerAll()
  {
    const bool stored = until([&] {
      const auto edits = server->edits();
      for (; answered < edits.size(); ++answered) {
        server->labels.publish(after(edits[answered]));
      }
      return session->unstored() == 0;
    });
    return stored ? testing::AssertionSuccess()
                  : testing::AssertionFailure()
                        << session->unstored() << " edits are not stored, " << session->failed()
                        << " of them failed: " << session->failure();
  }

  /// Somebody has stored this label; waits until the display has it.
  bool publish(const mesh_msgs::MeshFaceCluster& cluster)
  {
    server->labels.publish(cluster);
    const bool arrived = until([&] {
      const auto label = display->labels().find(cluster.label);
      return label == display->labels().end() ? cluster.face_indices.empty()
                                              : label->second->faces == cluster.face_indices;
    });
    session->work(nullptr);
    return arrived;
  }

  testing::AssertionResult received(std::size_t place, const std::string& label, const Faces& faces,
                                    bool override = true)
  {
    const auto edits = server->edits();
    const auto& edit = edits.at(place);
    if (edit.cluster.label == label && edit.cluster.face_indices == faces &&
        (edit.override != 0) == override && edit.uuid == "mesh" && edit.header.frame_id == "map") {
      return testing::AssertionSuccess();
    }
    return testing::AssertionFailure() << edit;
  }

  /// Shows a mesh of 125,000 faces under the same uuid, and waits until the server has answered
  /// which labels it has: what that knows nothing of would be gone.
  bool showLarge()
  {
    auto large = test_meshes::terrain(250, [](double, double) { return 0.0; });
    large.uuid = "mesh";
    large.header.frame_id = "map";
    geometry.publish(large);
    return until(
        [&] { return session->mesh()->faceCount() == 125000 && display->labelsComplete(); });
  }

  static rviz_mesh_plugin::FaceBits allOfLarge()
  {
    rviz_mesh_plugin::FaceBits all(125000);
    all.addAll();
    return all;
  }

  Display* display = nullptr;
  std::unique_ptr<rviz_mesh_plugin::LabelSession> session;
  ros::Subscriber everybody;
  std::size_t answered = 0;         ///< edits
  std::vector<std::string> copies;  ///< on /cluster_label
};
