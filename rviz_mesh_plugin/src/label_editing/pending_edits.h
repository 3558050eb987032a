#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "base/mesh_data.h"
#include "base/status_lines.h"
#include "labels/label_faces.h"

namespace rviz_mesh_plugin {

/// UUID and number of faces: another mesh may have the same UUID.
using MeshId = std::pair<std::string, std::size_t>;

/// What a label is to become.
struct LabelEdit
{
  MeshId mesh;
  std::string label;
  LabelFacesConstPtr faces;   ///< none: it is deleted; null: its color changes
  bool adds = false;          ///< the faces to those it has then, else instead of them
  LabelFacesConstPtr before;  ///< where it adds: those that it had when the edit was made,
  LabelFacesConstPtr whole;   ///< and with these
  std::vector<LabelFacesConstPtr> based_on;   ///< it has to have one of these then; empty: any
  std::vector<LabelFacesConstPtr> overtaken;  ///< or of these, which it may get until then
  std::optional<Rgba8> color;                 ///< of its own, or else that of its class
  std::string after;  ///< is sent when the edits of this label are stored; else empty

  /// Whether the label, which has these faces now, is none that this may be made of.
  bool hasChanged(const LabelFacesConstPtr& now) const;
};

/// Edits on their way to who stores labels. Each stays here until it has come back as stored, so
/// that none is lost; one that is replaced before that is forgotten.
class PendingEdits
{
 public:
  using Clock = std::chrono::steady_clock;

  /// So many are under way at a time: more would not fit into the queue of a publisher.
  static constexpr std::size_t AT_ONCE = 8;

  /// @param patience until an edit that was sent should be stored
  explicit PendingEdits(Clock::duration patience) : patience_(patience) {}

  void add(LabelEdit edit);

  /// Takes out what has been stored and returns it; then sends what can be sent.
  /// @param send returns why it cannot be sent, else an empty string
  /// @param ask is called once for an edit that was sent and has not come back within half of the
  /// patience: who stores it may have it, where only the message that says so is lost
  std::vector<LabelEdit> work(Clock::time_point now,
                              const std::function<bool(const LabelEdit&)>& is_stored,
                              const std::function<std::string(const LabelEdit&)>& send,
                              const std::function<void(const LabelEdit&)>& ask);

  /// Those that failed.
  void sendAgain();
  void giveUp() { edits_.clear(); }

  std::size_t count() const { return edits_.size(); }
  std::size_t failed() const;
  /// Why the first that failed did; empty where none has.
  std::string failure() const;
  /// On those that are under way; nothing where none is.
  OptionalStatus status() const;
  bool isPending(const MeshId& mesh, const std::string& label) const;
  /// Whether one was sent: its owner may store it any time.
  bool isSent(const MeshId& mesh, const std::string& label) const;
  /// The one of the faces of a label; null: there is none. Until this changes.
  const LabelEdit* find(const MeshId& mesh, const std::string& label) const;
  /// The one of its color.
  const LabelEdit* findColor(const MeshId& mesh, const std::string& label) const;
  /// The labels of a mesh that get faces.
  std::vector<std::string> labels(const MeshId& mesh) const;

 private:
  /// Mesh, label, whether of color.
  using Key = std::tuple<MeshId, std::string, bool>;
  struct Pending
  {
    LabelEdit edit;
    bool sent = false;
    Clock::time_point since;  ///< where it was sent
    bool asked = false;       ///< since then
    std::string failure;      ///< is not sent on its own any more
  };
  void breakCircle(const LabelEdit& edit);
  bool mustWait(const LabelEdit& edit) const;

  Clock::duration patience_;
  std::map<Key, Pending> edits_;
};

}  // namespace rviz_mesh_plugin
