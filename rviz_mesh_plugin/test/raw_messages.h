#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <ros/advertise_options.h>
#include <ros/message_traits.h>
#include <ros/node_handle.h>
#include <ros/publisher.h>
#include <ros/serialization.h>

/// The bytes of a message, whatever they are. Subscribers of an ordinary type in the same process
/// have to deserialize them, as those that come over the network.
struct RawBytes
{
  std::vector<std::uint8_t> bytes;
};

namespace ros {
namespace message_traits {

template <>
struct MD5Sum<RawBytes>
{
  static const char* value() { return "*"; }
  static const char* value(const RawBytes&) { return value(); }
};

template <>
struct DataType<RawBytes>
{
  static const char* value() { return "*"; }
  static const char* value(const RawBytes&) { return value(); }
};

template <>
struct Definition<RawBytes>
{
  static const char* value() { return ""; }
  static const char* value(const RawBytes&) { return value(); }
};

}  // namespace message_traits

namespace serialization {

template <>
struct Serializer<RawBytes>
{
  template <class Stream>
  static void write(Stream& stream, const RawBytes& message)
  {
    const auto size = static_cast<std::uint32_t>(message.bytes.size());
    std::copy(message.bytes.begin(), message.bytes.end(), stream.advance(size));
  }

  template <class Stream>
  static void read(Stream& stream, RawBytes& message)
  {
    const std::uint32_t size = stream.getLength();
    const std::uint8_t* data = stream.advance(size);
    message.bytes.assign(data, data + size);
  }

  static std::uint32_t serializedLength(const RawBytes& message)
  {
    return static_cast<std::uint32_t>(message.bytes.size());
  }
};

}  // namespace serialization
}  // namespace ros

namespace raw_messages {

template <class Message>
std::vector<std::uint8_t> bytesOf(const Message& message)
{
  std::vector<std::uint8_t> bytes(ros::serialization::serializationLength(message));
  ros::serialization::OStream stream(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
  ros::serialization::serialize(stream, message);
  return bytes;
}

/// Publishes raw bytes as messages of a type.
template <class Message>
ros::Publisher advertise(ros::NodeHandle& node, const std::string& topic)
{
  ros::AdvertiseOptions options;
  options.topic = topic;
  options.queue_size = 10;
  options.md5sum = ros::message_traits::md5sum<Message>();
  options.datatype = ros::message_traits::datatype<Message>();
  options.message_definition = ros::message_traits::definition<Message>();
  options.has_header = false;  // nothing may be written into the bytes
  return node.advertise(options);
}

/// The fields of a message one after the other: h header, s string, 1 4 8 plain values of so many
/// bytes, (n) an array of elements of n bytes.
///
/// Lengths that do not fit into the bytes are set to @a too_long elements: roscpp makes room for an
/// array before it looks whether there is as much, and a length of, say, a hundred million would
/// really be filled.
inline void restrainLengths(std::vector<std::uint8_t>& bytes, const std::string& fields,
                            std::uint32_t too_long)
{
  std::size_t at = 0;
  const auto skip = [&](std::size_t element, bool array) {
    if (at + 4 > bytes.size()) {
      return false;
    }
    std::uint32_t length = 0;
    std::copy_n(bytes.begin() + at, 4, reinterpret_cast<std::uint8_t*>(&length));
    at += 4;
    if (length > (bytes.size() - at) / element) {
      if (array) {
        std::copy_n(reinterpret_cast<const std::uint8_t*>(&too_long), 4, bytes.begin() + at - 4);
      }
      return false;
    }
    at += length * element;
    return true;
  };
  for (std::size_t i = 0; i < fields.size(); ++i) {
    if (fields[i] == 'h') {
      at += 12;
      if (!skip(1, false)) {
        return;
      }
    } else if (fields[i] == 's') {
      if (!skip(1, false)) {
        return;
      }
    } else if (fields[i] == '(') {
      const std::size_t end = fields.find(')', i);
      if (!skip(std::stoul(fields.substr(i + 1, end - i - 1)), true)) {
        return;
      }
      i = end;
    } else {
      at += static_cast<std::size_t>(fields[i] - '0');
    }
  }
}

}  // namespace raw_messages
