#pragma once

#include <array>
#include <cstddef>
#include <string>

namespace rviz_mesh_plugin {

/// How it went with the messages of one topic.
struct Reception
{
  std::size_t accepted = 0;
  std::size_t refused = 0;
  std::string refusal;       ///< why the newest message was refused; empty if it was accepted
  std::string last_refusal;  ///< why the last one was that was refused

  void accept()
  {
    ++accepted;
    refusal.clear();
  }
  void refuse(const std::string& reason)
  {
    ++refused;
    refusal = last_refusal = reason;
  }
  std::size_t received() const { return accepted + refused; }
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
