#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <string>
#include <utility>

namespace rviz_mesh_plugin {

/// Where something comes from, and whether it still has to.
struct Origin
{
  using Flag = std::atomic<bool>;

  /// @param of_service the name of the service whose answer it is; empty: a message of a topic
  Origin(const Flag* drop = nullptr, std::string of_service = std::string())
      : dropped(drop), service(std::move(of_service))
  {
  }

  bool isDropped() const { return dropped != nullptr && *dropped; }

  const Flag* dropped;
  std::string service;
};

/// How it went with the messages of one topic, and with what a service answered instead.
struct Reception
{
  std::size_t accepted = 0;  ///< messages
  std::size_t refused = 0;   ///< messages
  std::string refusal;       ///< why what came last was refused; empty if it was accepted
  std::string last_refusal;  ///< why the last message was that was refused
  std::size_t answers = 0;   ///< of services, accepted
  std::string service{};     ///< that the last of those came from
  std::string refused_of{};  ///< the service whose answer was refused last; empty: it was a message

  /// @param of the service whose answer it is; empty: a message
  void accept(const std::string& of = std::string())
  {
    ++(of.empty() ? accepted : answers);
    service = of.empty() ? service : of;
    refusal.clear();
    refused_of = of;
  }
  void refuse(const std::string& reason, const std::string& of = std::string())
  {
    refusal = reason;
    refused_of = of;
    if (of.empty()) {
      ++refused;
      last_refusal = reason;
    }
  }
  /// Messages.
  std::size_t received() const { return accepted + refused; }
  bool isEmpty() const { return received() + answers == 0; }
  /// What was refused last, and why; empty if it was accepted.
  std::string ignored() const
  {
    return refusal.empty()
               ? refusal
               : (refused_of.empty() ? "message" : "answer of the service " + refused_of) +
                     " ignored: " + refusal;
  }
};

/// What comes of a mesh, on a topic each.
enum class MeshMember
{
  GEOMETRY,
  COSTS,  ///< of vertices
  FACE_COSTS,
  UPDATES,  ///< of costs of vertices
  COLORS,
  MATERIALS,
  TEXTURES,
  LABELS
};
constexpr std::array<MeshMember, 8> MESH_MEMBERS = {
    MeshMember::GEOMETRY, MeshMember::COSTS,     MeshMember::FACE_COSTS, MeshMember::UPDATES,
    MeshMember::COLORS,   MeshMember::MATERIALS, MeshMember::TEXTURES,   MeshMember::LABELS};

/// Something for each of them.
template <class T>
class PerMember
{
 public:
  T& operator[](MeshMember part) { return all_[static_cast<std::size_t>(part)]; }
  const T& operator[](MeshMember part) const { return all_[static_cast<std::size_t>(part)]; }

 private:
  std::array<T, MESH_MEMBERS.size()> all_{};
};

}  // namespace rviz_mesh_plugin
