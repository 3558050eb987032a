#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <OgreColourValue.h>
#include <QColor>
#include <QObject>
#include <QString>

#include <ros/message_traits.h>
#include <rviz/properties/bool_property.h>
#include <rviz/properties/color_property.h>
#include <rviz/properties/enum_property.h>
#include <rviz/properties/float_property.h>
#include <rviz/properties/ros_topic_property.h>
#include <rviz/properties/string_property.h>

#include "base/mesh_data.h"
#include "base/qt_colors.h"

namespace rviz_mesh_plugin {

/// Makes properties of RViz whose changes are told in the same way.
class PropertyMaker
{
 public:
  /// @param changed is called after each change, as long as the receiver is there
  PropertyMaker(const QObject* receiver, std::function<void()> changed)
      : receiver_(receiver), changed_(std::move(changed))
  {
  }

  rviz::BoolProperty* box(const char* name, bool value, const char* description,
                          rviz::Property* parent) const
  {
    return connected(new rviz::BoolProperty(name, value, description, parent));
  }

  /// A box with properties below it, which can be changed where it is ticked.
  rviz::BoolProperty* group(const char* name, bool value, const char* description,
                            rviz::Property* parent) const
  {
    rviz::BoolProperty* group = box(name, value, description, parent);
    group->setDisableChildrenIfFalse(true);
    return group;
  }

  rviz::FloatProperty* number(const char* name, float value, const QString& description,
                              rviz::Property* parent,
                              float least = std::numeric_limits<float>::lowest(),
                              float greatest = std::numeric_limits<float>::max()) const
  {
    auto* number = connected(new rviz::FloatProperty(name, value, description, parent));
    number->setMin(least);
    number->setMax(greatest);
    return number;
  }

  /// A number from 0 (invisible) to 1 (opaque).
  rviz::FloatProperty* alpha(const char* name, const char* of_what, rviz::Property* parent) const
  {
    return number(name, 1.0f, QString("Opacity of the %1: 0 is invisible, 1 opaque.").arg(of_what),
                  parent, 0.0f, 1.0f);
  }

  rviz::ColorProperty* color(const char* name, const QColor& value, const char* description,
                             rviz::Property* parent) const
  {
    return connected(new rviz::ColorProperty(name, value, description, parent));
  }

  /// @param options numbered in this order
  rviz::EnumProperty* choice(const char* name, const char* value, const char* description,
                             rviz::Property* parent,
                             const std::vector<const char*>& options = {}) const
  {
    auto* choice = connected(new rviz::EnumProperty(name, value, description, parent));
    for (std::size_t i = 0; i < options.size(); ++i) {
      choice->addOption(options[i], static_cast<int>(i));
    }
    return choice;
  }

  rviz::StringProperty* line(const char* name, const char* value, const QString& description,
                             rviz::Property* parent) const
  {
    return connected(new rviz::StringProperty(name, value, description, parent));
  }

  template <class Message>
  rviz::RosTopicProperty* topic(const char* name, const char* description,
                                rviz::Property* parent) const
  {
    return connected(new rviz::RosTopicProperty(
        name, "", QString::fromLatin1(ros::message_traits::datatype<Message>()), description,
        parent));
  }

 private:
  template <class Property>
  Property* connected(Property* property) const
  {
    QObject::connect(property, &rviz::Property::changed, receiver_, changed_);
    return property;
  }

  const QObject* receiver_;
  const std::function<void()> changed_;
};

/// A value of which some parts are what properties say.
template <class Value>
class PropertyValue
{
 public:
  /// @param part a pointer to a member of the value, or a function that returns a reference into it
  /// @return the property
  template <class Property, class Part>
  Property* bind(Property* property, Part part)
  {
    reads_.push_back([property, part](Value& value) { read(property, std::invoke(part, value)); });
    return property;
  }

  Value get() const
  {
    Value value;
    for (const auto& read : reads_) {
      read(value);
    }
    return value;
  }

 private:
  static void read(const rviz::BoolProperty* property, bool& part) { part = property->getBool(); }
  /// Infinity and NaN do not count.
  static void read(const rviz::FloatProperty* property, float& part)
  {
    part = std::isfinite(property->getFloat()) ? property->getFloat() : part;
  }
  static void read(const rviz::ColorProperty* property, Ogre::ColourValue& part)
  {
    part = property->getOgreColor();
  }
  static void read(const rviz::ColorProperty* property, Rgba8& part)
  {
    part = toRgba8(property->getColor());
  }
  /// The first option where a file names one that does not exist here.
  template <class Part>
  static void read(rviz::EnumProperty* property, Part& part)
  {
    part = static_cast<Part>(std::max(0, property->getOptionInt()));
  }
  static void read(rviz::StringProperty* property, std::string& part)
  {
    part = property->getStdString();
  }

  std::vector<std::function<void(Value&)>> reads_;
};

}  // namespace rviz_mesh_plugin
