#include "ros_client/message_lengths.h"

#include <cstring>
#include <stdexcept>

namespace rviz_mesh_plugin {

std::uint32_t LengthReader::readLength()
{
  std::uint32_t length = 0;
  require(1, sizeof(length), nullptr);
  std::memcpy(&length, at_, sizeof(length));
  at_ += sizeof(length);
  return length;
}

void LengthReader::require(std::uint32_t count, std::size_t bytes_each, const char* what) const
{
  const std::uint64_t needed = std::uint64_t(count) * bytes_each;
  const auto left = static_cast<std::uint64_t>(end_ - at_);
  if (needed <= left) {
    return;
  }
  const std::string hint = "; it is damaged, or its publisher does not keep to the format";
  const std::string there = std::to_string(left) + " of the message's " + std::to_string(size_);
  throw std::length_error(
      (what ? "an array of " + std::to_string(count) + " " + what + " needs " +
                  std::to_string(needed) + " bytes, but only " + there + " are left"
       : size_ == 0 ? "the message is empty"
                    : "the message ends in the middle, after " + std::to_string(size_) + " bytes") +
      hint);
}

void LengthReader::skip(std::uint32_t count, std::size_t bytes_each, const char* what)
{
  require(count, bytes_each, what);
  at_ += std::size_t(count) * bytes_each;
}

}  // namespace rviz_mesh_plugin
