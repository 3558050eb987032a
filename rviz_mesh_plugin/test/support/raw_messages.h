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

}  // namespace raw_messages
