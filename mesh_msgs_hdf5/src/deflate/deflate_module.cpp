// mesh_msgs_hdf5._deflate: HDF5's filters shuffle and deflate for many chunks at a time. Private:
// mesh_msgs_hdf5.map_file.hdf5.chunks stores and loads with it. Arguments are checked here
// (ValueError), and the GIL is released while threads work.

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <string>
#include <utility>
#include <vector>

#include "deflate/chunk_codec.h"
#include "deflate/deflate.h"

namespace mesh_msgs_hdf5 {
namespace {

namespace py = pybind11;

// Bits of a chunk's flags.
constexpr unsigned SHUFFLED = 1, DEFLATED = 2;

ChunkGrid gridOf(const py::array& array, const std::vector<std::size_t>& chunk_shape)
{
  const char kind = array.dtype().kind();
  if ((array.flags() & py::array::c_style) == 0 || (kind != 'f' && kind != 'i' && kind != 'u')) {
    throw py::value_error("the array has to hold numbers, contiguous in C order");
  }
  const std::vector<std::size_t> shape(array.shape(), array.shape() + array.ndim());
  return ChunkGrid(shape, chunk_shape, static_cast<std::size_t>(array.itemsize()));
}

void checkRange(const ChunkGrid& grid, std::size_t first, std::size_t count)
{
  if (first > grid.chunkCount() || count > grid.chunkCount() - first) {
    throw py::value_error("the array has only " + std::to_string(grid.chunkCount()) + " chunks");
  }
}

py::list compress(const py::array& array, const std::vector<std::size_t>& chunk_shape,
                  bool shuffled, std::size_t first, std::size_t count, unsigned threads)
{
  const ChunkGrid grid = gridOf(array, chunk_shape);
  checkRange(grid, first, count);
  const auto* const data = static_cast<const std::uint8_t*>(array.data());
  std::vector<std::vector<std::uint8_t>> chunks;
  {
    const py::gil_scoped_release release;
    chunks = compressChunks(grid, data, shuffled, first, count, threads);
  }
  py::list result;
  for (const std::vector<std::uint8_t>& chunk : chunks) {
    result.append(py::bytes(reinterpret_cast<const char*>(chunk.data()), chunk.size()));
  }
  return result;
}

/// stored: (bytes, flags) of each chunk.
void decompress(const py::list& stored, const std::vector<std::size_t>& chunk_shape,
                std::size_t first, py::array& array, unsigned threads)
{
  const ChunkGrid grid = gridOf(array, chunk_shape);
  checkRange(grid, first, stored.size());
  std::vector<py::bytes> owners;  // keep the bytes alive, whatever becomes of the list
  std::vector<StoredChunk> chunks;
  for (const py::handle item : stored) {
    const auto [data, flags] = item.cast<std::pair<py::bytes, unsigned>>();
    owners.push_back(data);
    chunks.push_back({reinterpret_cast<const std::uint8_t*>(PyBytes_AS_STRING(data.ptr())),
                      static_cast<std::size_t>(PyBytes_GET_SIZE(data.ptr())),
                      (flags & SHUFFLED) != 0, (flags & DEFLATED) != 0});
  }
  auto* const data = static_cast<std::uint8_t*>(array.mutable_data());
  const py::gil_scoped_release release;
  decompressChunks(grid, chunks, first, data, threads);
}

}  // namespace

PYBIND11_MODULE(_deflate, module)
{
  using py::arg;
  module.attr("_SHUFFLED") = SHUFFLED;
  module.attr("_DEFLATED") = DEFLATED;
  module.attr("_WRITING_LIBRARY") = WRITING_LIBRARY;
  module.attr("_READING_LIBRARY") = READING_LIBRARY;
  module.def("_compress", &compress, arg("array").noconvert(), arg("chunk_shape"), arg("shuffled"),
             arg("first"), arg("count"), arg("threads") = 0);
  module.def("_decompress", &decompress, arg("stored"), arg("chunk_shape"), arg("first"),
             arg("array").noconvert(), arg("threads") = 0);
}

}  // namespace mesh_msgs_hdf5
