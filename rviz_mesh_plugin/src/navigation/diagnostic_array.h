#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <ros/message_traits.h>
#include <ros/serialization.h>
#include <std_msgs/Header.h>

namespace rviz_mesh_plugin {

/// What is said on /diagnostics: diagnostic_msgs/DiagnosticArray and its parts as they are on the
/// wire, so that the plugin needs no other package for this one message.
struct DiagnosticValue
{
  std::string key;
  std::string value;
};

struct DiagnosticStatus
{
  std::int8_t level = 0;  ///< 0: all is well, 1: a warning, 2: an error, 3: out of date
  std::string name;       ///< "<node>: <part of it>"
  std::string message;
  std::string hardware_id;
  std::vector<DiagnosticValue> values;
};

struct DiagnosticArray
{
  std_msgs::Header header;
  std::vector<DiagnosticStatus> status;
};

}  // namespace rviz_mesh_plugin

namespace ros {
namespace message_traits {

template <>
struct MD5Sum<rviz_mesh_plugin::DiagnosticArray>
{
  static const char* value() { return "60810da900de1dd6ddd437c3503511da"; }
  static const char* value(const rviz_mesh_plugin::DiagnosticArray&) { return value(); }
};

template <>
struct DataType<rviz_mesh_plugin::DiagnosticArray>
{
  static const char* value() { return "diagnostic_msgs/DiagnosticArray"; }
  static const char* value(const rviz_mesh_plugin::DiagnosticArray&) { return value(); }
};

template <>
struct IsMessage<rviz_mesh_plugin::DiagnosticArray> : TrueType
{
};

template <>
struct HasHeader<rviz_mesh_plugin::DiagnosticArray> : TrueType
{
};

}  // namespace message_traits

namespace serialization {

template <>
struct Serializer<rviz_mesh_plugin::DiagnosticValue>
{
  template <class Stream, class T>
  static void allInOne(Stream& stream, T m)
  {
    stream.next(m.key);
    stream.next(m.value);
  }
  ROS_DECLARE_ALLINONE_SERIALIZER
};

template <>
struct Serializer<rviz_mesh_plugin::DiagnosticStatus>
{
  template <class Stream, class T>
  static void allInOne(Stream& stream, T m)
  {
    stream.next(m.level);
    stream.next(m.name);
    stream.next(m.message);
    stream.next(m.hardware_id);
    stream.next(m.values);
  }
  ROS_DECLARE_ALLINONE_SERIALIZER
};

template <>
struct Serializer<rviz_mesh_plugin::DiagnosticArray>
{
  template <class Stream, class T>
  static void allInOne(Stream& stream, T m)
  {
    stream.next(m.header);
    stream.next(m.status);
  }
  ROS_DECLARE_ALLINONE_SERIALIZER
};

}  // namespace serialization
}  // namespace ros
