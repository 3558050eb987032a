#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace rviz_mesh_plugin {

/// Packs ascending faces into runs: for each the faces left out before it, then its length, as
/// numbers of 7 bits a byte, the lowest first.
class RunWriter
{
 public:
  void add(std::uint32_t begin, std::uint32_t count)
  {
    if (begin != end_ || end_ == begin_) {
      flush();
      begin_ = begin;
    }
    end_ = begin + count;
  }

  std::vector<std::uint8_t> take()
  {
    flush();
    bytes_.shrink_to_fit();
    return std::move(bytes_);
  }

 private:
  void flush()
  {
    if (end_ > begin_) {
      write(begin_ - written_);
      write(end_ - begin_);
      written_ = end_;
    }
  }

  void write(std::uint32_t number)
  {
    for (; number >= 0x80; number >>= 7) {
      bytes_.push_back(static_cast<std::uint8_t>(number | 0x80));
    }
    bytes_.push_back(static_cast<std::uint8_t>(number));
  }

  std::vector<std::uint8_t> bytes_;
  std::uint32_t begin_ = 0;
  std::uint32_t end_ = 0;
  std::uint32_t written_ = 0;
};

/// The next number that a RunWriter has written; @a at goes on behind it.
inline std::uint32_t readNumber(const std::vector<std::uint8_t>& bytes, std::size_t& at)
{
  std::uint32_t number = 0;
  for (unsigned shift = 0;; shift += 7) {
    const std::uint8_t byte = bytes[at++];
    number |= static_cast<std::uint32_t>(byte & 0x7F) << shift;
    if (byte < 0x80) {
      return number;
    }
  }
}

}  // namespace rviz_mesh_plugin
