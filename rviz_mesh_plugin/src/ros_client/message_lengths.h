#pragma once

#include <cstddef>
#include <cstdint>
#include <exception>
#include <string>
#include <vector>

#include <ros/message_traits.h>
#include <ros/serialization.h>
#include <boost/array.hpp>

namespace rviz_mesh_plugin {

/// Reads a message, of any type, without keeping anything of it: a stream for ros::serialization
/// that looks whether the bytes are there which lengths of arrays and texts announce. (roscpp makes
/// room for them first, and fills it.)
class LengthReader
{
 public:
  LengthReader(const std::uint8_t* bytes, std::size_t size)
      : at_(bytes), end_(bytes + size), size_(size)
  {
  }

  template <class T>
  void next(T& value)
  {
    if constexpr (ros::message_traits::IsFixedSize<T>::value) {
      skip(1, ros::serialization::serializationLength(value), nullptr);
    } else {
      ros::serialization::Serializer<T>::read(*this, value);
    }
  }

  void next(std::string& /*text*/) { skip(readLength(), 1, "characters"); }

  template <class T, class Allocator>
  void next(std::vector<T, Allocator>& /*array*/)
  {
    const std::uint32_t length = readLength();
    T element{};
    const std::size_t least = ros::serialization::serializationLength(element);
    if constexpr (ros::message_traits::IsFixedSize<T>::value) {
      skip(length, least, nameOf<T>());
    } else {
      require(length, least, nameOf<T>());
      for (std::uint32_t i = 0; i < length; ++i) {
        next(element);
      }
    }
  }

  template <class T, std::size_t N>
  void next(boost::array<T, N>& array)
  {
    for (T& element : array) {
      next(element);
    }
  }

 private:
  template <class T>
  static const char* nameOf()
  {
    if constexpr (ros::message_traits::IsMessage<T>::value) {
      return ros::message_traits::datatype<T>();
    } else {
      return "elements";
    }
  }

  std::uint32_t readLength();
  /// @param what null: no array. @throw std::length_error
  void require(std::uint32_t count, std::size_t bytes_each, const char* what) const;
  void skip(std::uint32_t count, std::size_t bytes_each, const char* what);

  const std::uint8_t* at_;
  const std::uint8_t* end_;
  std::size_t size_;
};

/// Why these bytes cannot be a message of this type; empty if they can.
template <class Message>
std::string findFalseLength(const std::uint8_t* bytes, std::size_t size)
{
  try {
    Message message;
    LengthReader(bytes, size).next(message);
  } catch (const std::exception& error) {
    return error.what();
  }
  return std::string();
}

}  // namespace rviz_mesh_plugin
