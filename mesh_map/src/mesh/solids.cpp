#include "mesh/solids.h"

#include <mesh_map/mesh/topology.h>

#include "base/require.h"

namespace mesh_map {

std::vector<std::uint32_t> findSolids(ArrayView<std::uint32_t> face_edges,
                                      ArrayView<std::uint8_t> face_flags, std::size_t edge_count)
{
  const std::size_t face_count = face_flags.size();
  require(face_edges.size() == 3 * face_count, "three edges per face are needed");
  const EdgeFaces at_edges = edgeFaces(face_edges, edge_count);
  constexpr std::uint32_t UNSEEN = NO_INDEX - 1;
  std::vector<std::uint32_t> solids(face_count, UNSEEN), patch;
  std::uint32_t count = 0;
  for (std::uint32_t seed = 0; seed < face_count; ++seed) {
    if (solids[seed] != UNSEEN) {
      continue;
    }
    bool closed = (face_flags[seed] & FACE_DEGENERATE) == 0;
    patch.assign(1, seed);
    solids[seed] = count;
    for (std::size_t i = 0; closed && i < patch.size(); ++i) {
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t edge = face_edges[3 * std::size_t{patch[i]} + k];
        const std::size_t begin = at_edges.offsets[edge], end = at_edges.offsets[edge + 1];
        closed = closed && (end - begin) % 2 == 0;
        for (std::size_t j = begin; (end - begin) % 2 == 0 && j < end; ++j) {
          const std::uint32_t other = at_edges.faces[j];
          if (solids[other] == UNSEEN) {
            solids[other] = count;
            patch.push_back(other);
          } else if (solids[other] == NO_INDEX) {
            closed = false;  // what it is part of was found to be open
          }
        }
      }
    }
    if (closed) {
      ++count;
    } else {
      for (const std::uint32_t face : patch) {
        solids[face] = NO_INDEX;
      }
    }
  }
  return solids;
}

}  // namespace mesh_map
