#pragma once

#include <cstddef>
#include <memory>
#include <string>

#include "labels/face_parents.h"
#include "threads/cancellation.h"
#include "threads/work_thread.h"

namespace rviz_mesh_plugin {

/// Of what meshes were made, as get_derived_mesh tells. GUI thread only; nothing waits for an
/// answer.
class FaceParentsSource
{
 public:
  FaceParentsSource();

  /// Asks in this namespace from now on; nothing where it is empty. What is known stays, if it is
  /// of that namespace.
  void connect(const std::string& name_space);
  void disconnect();

  /// Asks for a mesh, unless that is known or being asked. Where nobody answers for some seconds,
  /// it may be asked for again: most who own labels know of no such meshes.
  /// @param face_count of the mesh; what says something of another number is refused
  void request(const std::string& uuid, std::size_t face_count);

  /// Null: it was made of none, or that is not known.
  FaceParentsConstPtr parents(const std::string& uuid) const;

 private:
  struct Known;
  static void ask(Known& known, const std::string& service, const std::string& uuid,
                  std::size_t face_count, const Cancellation& cancellation);

  std::string namespace_;
  bool connected_ = false;
  std::shared_ptr<Known> known_;
  WorkThread thread_{"face parents", NAME_PATIENCE};
};

}  // namespace rviz_mesh_plugin
