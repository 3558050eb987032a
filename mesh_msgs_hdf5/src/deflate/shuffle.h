#ifndef MESH_MSGS_HDF5_SRC_SHUFFLE_H
#define MESH_MSGS_HDF5_SRC_SHUFFLE_H

#include <cstddef>
#include <cstdint>

namespace mesh_msgs_hdf5 {

// HDF5's shuffle filter: a chunk of N items of S bytes becomes S planes of N bytes, first all first
// bytes, then all second ones. These move a part of the items: `planes` points at the place of the
// first of them in the first plane, `plane_size` is N.

void shuffle(const std::uint8_t* items, std::size_t count, std::size_t item_size,
             std::uint8_t* planes, std::size_t plane_size);

void unshuffle(const std::uint8_t* planes, std::size_t plane_size, std::size_t count,
               std::size_t item_size, std::uint8_t* items);

}  // namespace mesh_msgs_hdf5

#endif  // MESH_MSGS_HDF5_SRC_SHUFFLE_H
