#include "properties/cost_properties.h"

#include <cmath>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <osmesa_harness/render_fixture.h>
#include <rviz/config.h>
#include <rviz/properties/enum_property.h>
#include <rviz/properties/property.h>
#include <QObject>

using rviz_mesh_plugin::ColorScale;
using rviz_mesh_plugin::CostColoring;
using rviz_mesh_plugin::CostProperties;
using rviz_mesh_plugin::Rgba8;

namespace {

struct SignalCounts
{
  int topics = 0;
  int coloring = 0;
  int legend = 0;
};

/// Only to have an application, which the properties need.
class CostPropertiesTest : public osmesa_harness::RenderFixture
{
 protected:
  CostPropertiesTest()
  {
    QObject::connect(properties, &CostProperties::topicsChanged,
                     [this] { ++signal_counts.topics; });
    QObject::connect(properties, &CostProperties::coloringChanged,
                     [this] { ++signal_counts.coloring; });
    QObject::connect(properties, &CostProperties::legendChanged,
                     [this] { ++signal_counts.legend; });
  }

  rviz::Property* sub(const std::vector<const char*>& path)
  {
    rviz::Property* property = &parent;
    for (const char* name : path) {
      property = property->subProp(name);
    }
    return property;
  }

  rviz::Property parent{"Display Type"};
  CostProperties* properties = new CostProperties(&parent);
  SignalCounts signal_counts;
};

struct PropertyCase
{
  std::vector<const char*> path;
  QVariant standard;
  QVariant other;
};

const std::vector<PropertyCase>& allProperties()
{
  static const std::vector<PropertyCase> cases{
      {{"Color Scale"}, "Rainbow", "Turbo"},
      {{"Vertex Costs Topic"}, "", "/map/vertex_costs"},
      {{"Update Topic"}, "", "/elsewhere"},
      {{"Face Costs Topic"}, "", "/map/face_costs"},
      {{"Vertex Costs Type"}, "-- None --", "height_diff"},
      {{"Use Custom limits"}, false, true},
      {{"Use Custom limits", "Vertex Costs Lower Limit"}, 0.0f, -2.5f},
      {{"Use Custom limits", "Vertex Costs Upper Limit"}, 1.0f, 7.25f},
      {{"Clip Percentile"}, 0.0f, 2.0f},
      {{"Invert Colors"}, false, true},
      {{"Logarithmic"}, false, true},
      {{"Lethal Color"}, QColor(255, 20, 147), QColor(1, 2, 3)},
      {{"Mark Lethal"}, true, false},
      {{"Unknown Color"}, QColor(104, 78, 40), QColor(4, 5, 6)},
      {{"Mark Outside Limits"}, false, true},
      {{"Mark Outside Limits", "Below Color"}, QColor(0, 0, 0), QColor(7, 8, 9)},
      {{"Mark Outside Limits", "Above Color"}, QColor(255, 255, 255), QColor(10, 11, 12)},
      {{"Legend"}, true, false},
      {{"Legend", "Unit"}, "", "m"},
  };
  return cases;
}

QString textOf(const QVariant& value)
{
  return value.type() == QVariant::Color ? QString("%1; %2; %3")
                                               .arg(value.value<QColor>().red())
                                               .arg(value.value<QColor>().green())
                                               .arg(value.value<QColor>().blue())
                                         : value.toString();
}

}  // namespace

TEST_F(CostPropertiesTest, names_defaults_and_nesting)
{
  int count = 0;
  for (const PropertyCase& test : allProperties()) {
    rviz::Property* property = sub(test.path);
    ASSERT_EQ(property->getNameStd(), test.path.back());
    EXPECT_EQ(property->getValue().toString(), textOf(test.standard)) << test.path.back();
    EXPECT_FALSE(property->getDescription().isEmpty()) << test.path.back();
    count += test.path.size() == 1;
  }
  EXPECT_EQ(parent.numChildren(), count);
}

TEST_F(CostPropertiesTest, defaults_reproduce_the_released_colors)
{
  const CostColoring coloring = properties->coloring();
  // As the released plugin draws costs from 0 to 1.
  const std::vector<std::pair<float, Rgba8>> released{
      {0.0f, {255, 0, 255, 255}}, {0.2f, {0, 0, 255, 255}},   {0.4f, {0, 255, 255, 255}},
      {0.6f, {0, 255, 0, 255}},   {0.8f, {255, 255, 0, 255}}, {1.0f, {255, 0, 0, 255}}};
  for (const auto& [cost, color] : released) {
    EXPECT_EQ(rviz_mesh_plugin::scaleColor(coloring.scale, cost), color) << cost;
  }
  EXPECT_FALSE(coloring.inverted);
  EXPECT_FALSE(coloring.logarithmic);
  EXPECT_FALSE(coloring.custom_limits);
  EXPECT_EQ(coloring.limits.lower, 0.0f);
  EXPECT_EQ(coloring.limits.upper, 1.0f);
  EXPECT_EQ(coloring.clipped, 0.0f);
  EXPECT_FALSE(coloring.mark_outside);
  // Ours, as in the README: pink and brown, which no scale has.
  EXPECT_TRUE(coloring.mark_lethal);
  EXPECT_EQ(coloring.lethal, (Rgba8{255, 20, 147, 255}));
  EXPECT_EQ(coloring.unknown, (Rgba8{104, 78, 40, 255}));
  EXPECT_TRUE(properties->legend());
  EXPECT_EQ(properties->costsType(), "");
  EXPECT_EQ(properties->unit(), "");
}

TEST_F(CostPropertiesTest, each_property_changes_what_it_says_and_is_saved)
{
  for (const PropertyCase& test : allProperties()) {
    const SignalCounts signals_before = signal_counts;
    const CostColoring before = properties->coloring();
    sub(test.path)->setValue(test.other);
    const std::string name = test.path.back();
    const bool is_topic = name.find("Topic") != std::string::npos;
    const bool is_legend = name == "Legend" || name == "Unit";
    EXPECT_EQ(signal_counts.topics - signals_before.topics, is_topic ? 1 : 0) << name;
    EXPECT_EQ(signal_counts.legend - signals_before.legend, is_legend ? 1 : 0) << name;
    EXPECT_EQ(signal_counts.coloring - signals_before.coloring, is_topic || is_legend ? 0 : 1)
        << name;
    EXPECT_EQ(properties->coloring() != before,
              !is_topic && !is_legend && name != "Vertex Costs Type")
        << name;
  }
  const CostColoring coloring = properties->coloring();
  EXPECT_EQ(coloring.scale, ColorScale::TURBO);
  EXPECT_EQ(coloring.limits.lower, -2.5f);
  EXPECT_EQ(coloring.limits.upper, 7.25f);
  EXPECT_EQ(coloring.clipped, 2.0f);
  EXPECT_EQ(coloring.lethal, (Rgba8{1, 2, 3, 255}));
  EXPECT_EQ(coloring.unknown, (Rgba8{4, 5, 6, 255}));
  EXPECT_EQ(coloring.below, (Rgba8{7, 8, 9, 255}));
  EXPECT_EQ(coloring.above, (Rgba8{10, 11, 12, 255}));
  rviz::Config config;
  parent.save(config);
  rviz::Property other_parent("Display Type");
  auto* loaded = new CostProperties(&other_parent);
  other_parent.load(config);
  EXPECT_TRUE(loaded->coloring() == coloring);
  EXPECT_EQ(loaded->costsTopic(), "/map/vertex_costs");
  EXPECT_EQ(loaded->updateTopic(), "/elsewhere");
  EXPECT_EQ(loaded->faceCostsTopic(), "/map/face_costs");
  EXPECT_EQ(loaded->costsType(), "height_diff");
  EXPECT_EQ(loaded->unit(), "m");
  EXPECT_FALSE(loaded->legend());
}

TEST_F(CostPropertiesTest, all_scales_are_offered)
{
  for (const auto& named : rviz_mesh_plugin::colorScales()) {
    sub({"Color Scale"})->setValue(named.name);
    EXPECT_EQ(properties->coloring().scale, named.scale) << named.name;
  }
  sub({"Color Scale"})->setValue("Of A Later Version");
  EXPECT_EQ(properties->coloring().scale, ColorScale::RAINBOW);
}

TEST_F(CostPropertiesTest, updates_come_from_below_the_costs_unless_told_otherwise)
{
  EXPECT_EQ(properties->updateTopic(), "");
  properties->setCostsTopic("/map/vertex_costs");
  sub({"Face Costs Topic"})->setValue("/map/face_costs");
  EXPECT_EQ(properties->costsTopic(), "/map/vertex_costs");
  EXPECT_EQ(properties->faceCostsTopic(), "/map/face_costs");
  EXPECT_EQ(properties->updateTopic(), "/map/vertex_costs/updates");
  sub({"Update Topic"})->setValue("/map/changes");
  EXPECT_EQ(properties->updateTopic(), "/map/changes");
}

TEST_F(CostPropertiesTest, the_choice_waits_for_its_layer)
{
  auto* type = dynamic_cast<rviz::EnumProperty*>(sub({"Vertex Costs Type"}));
  ASSERT_TRUE(type);
  type->setValue("ridge");
  const int before = signal_counts.coloring;
  properties->setCostsTypes({"height_diff", "ridge"});
  EXPECT_EQ(properties->costsType(), "ridge");
  properties->setCostsTypes({"height_diff"});
  EXPECT_EQ(properties->costsType(), "ridge");
  properties->setCostsTypes({});
  EXPECT_EQ(properties->costsType(), "ridge");
  EXPECT_EQ(signal_counts.coloring, before);
}

TEST_F(CostPropertiesTest, what_does_not_matter_is_hidden)
{
  using Seen = CostProperties::Seen;
  properties->setSeen(Seen::NONE);
  for (const PropertyCase& test : allProperties()) {
    if (test.path.size() == 1) {
      EXPECT_TRUE(sub(test.path)->getHidden()) << test.path[0];
    }
  }
  sub({"Use Custom limits"})->setValue(true);
  EXPECT_TRUE(sub({"Clip Percentile"})->getHidden());
  properties->setTopicsHidden(true);
  properties->setSeen(Seen::ALL);
  for (const PropertyCase& test : allProperties()) {
    const std::string name = test.path[0];
    EXPECT_EQ(sub({test.path[0]})->getHidden(),
              name.find("Topic") != std::string::npos || name == "Clip Percentile")
        << name;
  }
  sub({"Use Custom limits"})->setValue(false);
  EXPECT_FALSE(sub({"Clip Percentile"})->getHidden());
  properties->setSeen(Seen::SCALE);
  for (const PropertyCase& test : allProperties()) {
    const std::set<std::string> of_heights{"Color Scale", "Use Custom limits", "Invert Colors",
                                           "Legend"};
    EXPECT_EQ(sub({test.path[0]})->getHidden(), of_heights.count(test.path[0]) == 0)
        << test.path[0];
  }
}

TEST_F(CostPropertiesTest, numbers_stay_in_their_range)
{
  sub({"Clip Percentile"})->setValue(80.0f);
  EXPECT_EQ(properties->coloring().clipped, 49.0f);
  sub({"Clip Percentile"})->setValue(-1.0f);
  EXPECT_EQ(properties->coloring().clipped, 0.0f);
  for (const float odd : {INFINITY, -INFINITY, NAN}) {
    sub({"Use Custom limits", "Vertex Costs Upper Limit"})->setValue(odd);
    EXPECT_TRUE(std::isfinite(properties->coloring().limits.upper)) << odd;
  }
}
