#include "labels/label_name.h"

#include <string>

#include <gtest/gtest.h>
#include <QFile>
#include <QJsonArray>
#include <QJsonDocument>
#include <QJsonObject>

using rviz_mesh_plugin::joinLabel;
using rviz_mesh_plugin::labelFault;
using rviz_mesh_plugin::labelInstance;
using rviz_mesh_plugin::nextInstance;
using rviz_mesh_plugin::whyNoLabel;

TEST(LabelNames, are_split_at_the_first_underscore_and_counted)
{
  EXPECT_EQ(labelInstance("tree_1_b"), "1_b");
  EXPECT_EQ(labelInstance("tree"), "");
  EXPECT_EQ(joinLabel("tree", "1"), "tree_1");
  EXPECT_EQ(joinLabel("tree", ""), "tree");
  EXPECT_EQ(nextInstance("tree", {}), "1");
  EXPECT_EQ(nextInstance("tree", {"tree_2", "tree_10", "tree_x", "wall_99", "tree"}), "11");
  EXPECT_EQ(nextInstance("tree", {"tree_99999999999999999999"}), "1");
}

TEST(LabelNames, are_usable_where_python_says_so)
{
  QFile file(LABEL_NAMES);
  ASSERT_TRUE(file.open(QIODevice::ReadOnly)) << LABEL_NAMES;
  const QJsonArray cases = QJsonDocument::fromJson(file.readAll()).array();
  ASSERT_GE(cases.size(), 40);
  for (const auto& entry : cases) {
    const QJsonObject one = entry.toObject();
    const std::string label = one["label"].toString().toStdString();
    const bool usable = one["usable"].toBool();
    EXPECT_EQ(labelFault(label).empty(), usable) << one["name"].toString().toStdString();
    EXPECT_EQ(whyNoLabel(label).empty(), usable) << one["name"].toString().toStdString();
  }
}

TEST(LabelNames, say_what_is_wrong)
{
  EXPECT_NE(whyNoLabel("").find("needs a name"), std::string::npos);
  EXPECT_EQ(labelFault("a\xFF"), "is no UTF-8");
  EXPECT_EQ(labelFault("a\xED\xB3\xBF"), "is no UTF-8") << "half of a surrogate pair";
  EXPECT_EQ(labelFault("a\xE2\x81\xA7"), "contains U+2067, which makes it look like another");
  EXPECT_EQ(labelFault(std::string(256, 'a')), "has 256 bytes");
  EXPECT_EQ(
      whyNoLabel("a/b"),
      "the name of the label contains a slash: call it like tree_1, class and instance, in up to "
      "255 bytes");
}
