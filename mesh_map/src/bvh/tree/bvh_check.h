#pragma once

#include <mesh_map/base/array_view.h>

#include <cstddef>

namespace mesh_map {

class Run;

/// Throws std::invalid_argument for no faces, or too many.
void checkFaceCount(const MeshView& mesh);

/// Whether these faces refer to vertices that exist, all of them finite.
bool facesAreSound(const MeshView& mesh, std::size_t begin, std::size_t end);

/// Throws std::invalid_argument for the first face that is not sound.
[[noreturn]] void refuseFaces(const MeshView& mesh);

/// All of it, on all threads.
void checkMesh(const MeshView& mesh, Run& run, double share);

}  // namespace mesh_map
