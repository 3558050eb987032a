#include <algorithm>
#include <stdexcept>
#include <string>

#include "bvh_boxes.h"
#include "bvh_check.h"
#include "bvh_run.h"

namespace mesh_map {

namespace {

constexpr double CHECK_SHARE = 0.2;

}  // namespace

void Bvh::refit(const MeshView& mesh, const BvhOptions& options)
{
  Run run(options);
  run.check();
  if (mesh.faceCount() != faceCount()) {
    throw std::invalid_argument("the mesh has " + std::to_string(mesh.faceCount()) +
                                " faces, but the spatial index is one of " +
                                std::to_string(faceCount()) +
                                ": build a new one where faces have changed");
  }
  checkMesh(mesh, run, CHECK_SHARE);

  // All is made anew and then exchanged, so that nothing has changed where something is thrown.
  LargeArray<BvhNode> nodes(nodes_);
  LargeArray<float> corners(corners_.size());
  std::fill(corners.end() - TAIL, corners.end(), 0.0f);
  computeBoxes(
      {mesh, LocalFrame(center_), faces_.data(), nodes.data(), nodes.size(), corners.data()}, run,
      1.0 - CHECK_SHARE);
  run.finish();
  nodes_.swap(nodes);
  corners_.swap(corners);
  setBox();
}

}  // namespace mesh_map
