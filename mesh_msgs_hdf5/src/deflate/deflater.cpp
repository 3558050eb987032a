// Writing: isa-l where it was found (four times as fast as libdeflate and ten times as zlib on
// shuffled floats, for files 4 % larger), else libdeflate, else zlib; each at the level that was
// the best deal.

#include <new>
#include <stdexcept>
#include <string>
#include <vector>

#include "deflate/deflate.h"

#if defined(MESH_MSGS_HDF5_ISAL)
#include <isa-l/igzip_lib.h>
#elif defined(MESH_MSGS_HDF5_LIBDEFLATE)
#include <libdeflate.h>
#else
#include <zlib.h>
#endif

namespace mesh_msgs_hdf5 {
namespace {

[[noreturn]] void fail()
{
  throw std::runtime_error(std::string(WRITING_LIBRARY) + " cannot compress a chunk");
}

}  // namespace

#if defined(MESH_MSGS_HDF5_ISAL)

const char* const WRITING_LIBRARY = "isa-l";

struct Deflater::State
{
  isal_zstream stream;
  std::vector<std::uint8_t> level_memory;
};

Deflater::Deflater() : state_(std::make_unique<State>())
{
  state_->level_memory.resize(ISAL_DEF_LVL2_EXTRA_LARGE);
}

std::size_t Deflater::bound(std::size_t size)
{
  // Where a block does not shrink it is stored, with 5 bytes before each 64 KiB of it.
  return size + size / 1024 + 1024;
}

std::size_t Deflater::compress(const std::uint8_t* input, std::size_t size, std::uint8_t* output)
{
  isal_zstream& stream = state_->stream;
  isal_deflate_stateless_init(&stream);
  stream.level = 2;
  stream.level_buf = state_->level_memory.data();
  stream.level_buf_size = static_cast<std::uint32_t>(state_->level_memory.size());
  stream.gzip_flag = IGZIP_ZLIB;
  stream.flush = NO_FLUSH;
  stream.end_of_stream = 1;
  stream.next_in = const_cast<std::uint8_t*>(input);  // isa-l does not write there
  stream.avail_in = static_cast<std::uint32_t>(size);
  stream.next_out = output;
  stream.avail_out = static_cast<std::uint32_t>(bound(size));
  if (isal_deflate_stateless(&stream) != COMP_OK || stream.avail_in != 0) {
    fail();
  }
  return stream.total_out;
}

#elif defined(MESH_MSGS_HDF5_LIBDEFLATE)

const char* const WRITING_LIBRARY = "libdeflate";

struct Deflater::State
{
  State() : compressor(libdeflate_alloc_compressor(1), &libdeflate_free_compressor)
  {
    if (!compressor) {
      throw std::bad_alloc();
    }
  }

  std::unique_ptr<libdeflate_compressor, decltype(&libdeflate_free_compressor)> compressor;
};

Deflater::Deflater() : state_(std::make_unique<State>()) {}

std::size_t Deflater::bound(std::size_t size)
{
  return libdeflate_zlib_compress_bound(nullptr, size);
}

std::size_t Deflater::compress(const std::uint8_t* input, std::size_t size, std::uint8_t* output)
{
  const std::size_t written =
      libdeflate_zlib_compress(state_->compressor.get(), input, size, output, bound(size));
  if (written == 0) {
    fail();
  }
  return written;
}

#else

const char* const WRITING_LIBRARY = "zlib";

struct Deflater::State
{
};

Deflater::Deflater() = default;

std::size_t Deflater::bound(std::size_t size)
{
  return compressBound(size);
}

std::size_t Deflater::compress(const std::uint8_t* input, std::size_t size, std::uint8_t* output)
{
  uLongf written = bound(size);
  if (compress2(output, &written, input, size, 1) != Z_OK) {
    fail();
  }
  return written;
}

#endif

Deflater::~Deflater() = default;

}  // namespace mesh_msgs_hdf5
