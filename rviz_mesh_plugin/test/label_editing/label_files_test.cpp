#include <fstream>
#include <functional>
#include <iterator>
#include <random>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <QFile>
#include <QJsonArray>
#include <QJsonDocument>
#include <QJsonObject>
#include <QTemporaryDir>

#include "label_editing/label_files.h"

using rviz_mesh_plugin::FileLabel;
using rviz_mesh_plugin::FileLabels;
using rviz_mesh_plugin::LabelFile;
using rviz_mesh_plugin::LabelFileError;
using rviz_mesh_plugin::labelsFromCsv;
using rviz_mesh_plugin::labelsFromJson;
using rviz_mesh_plugin::labelsToCsv;
using rviz_mesh_plugin::labelsToJson;
using rviz_mesh_plugin::readLabelFile;
using rviz_mesh_plugin::Rgba8;
using rviz_mesh_plugin::writeLabelFile;

namespace {

bool operator==(const FileLabel& a, const FileLabel& b)
{
  return a.faces == b.faces && a.color == b.color;
}

bool same(const FileLabels& a, const FileLabels& b)
{
  return a.size() == b.size() &&
         std::equal(a.begin(), a.end(), b.begin(), [](const auto& left, const auto& right) {
           return left.first == right.first && left.second == right.second;
         });
}

FileLabels randomLabels(std::mt19937& random, std::size_t face_count)
{
  const auto below = [&](std::size_t limit) { return random() % limit; };
  const std::vector<std::string> letters = {"a",  "Z", "9", "_",  ",", ";",
                                            "\"", " ", "ä", "木", "\\"};
  FileLabels labels;
  for (std::size_t i = below(6); i > 0; --i) {
    std::string name;
    for (std::size_t j = 1 + below(8); j > 0; --j) {
      name += letters[below(letters.size())];
    }
    std::set<std::uint32_t> faces;
    for (std::size_t j = below(4); j > 0; --j) {
      const std::size_t first = below(face_count);
      for (std::size_t k = first; k < std::min(face_count, first + below(9)); ++k) {
        faces.insert(static_cast<std::uint32_t>(k));
      }
    }
    FileLabel& label = labels[name];
    label.faces.assign(faces.begin(), faces.end());
    if (below(2) == 0) {
      const auto channel = [&] { return static_cast<std::uint8_t>(below(256)); };
      label.color = Rgba8{channel(), channel(), channel(), 255};
    }
  }
  return labels;
}

std::string reasonOf(const std::function<void()>& work)
{
  try {
    work();
  } catch (const LabelFileError& error) {
    return error.what();
  }
  return "nothing was wrong";
}

void expectReason(const std::string& text, bool json, const std::string& reason)
{
  const std::string said =
      reasonOf([&] { json ? void(labelsFromJson(text, 10)) : void(labelsFromCsv(text, 10)); });
  EXPECT_NE(said.find(reason), std::string::npos) << text << "\nis refused: " << said;
}

/// Of a case of the corpus.
FileLabels labelsOf(const QJsonObject& entries)
{
  FileLabels labels;
  for (auto entry = entries.begin(); entry != entries.end(); ++entry) {
    FileLabel& label = labels[entry.key().toStdString()];
    for (const auto& face : entry.value().toObject()["faces"].toArray()) {
      label.faces.push_back(static_cast<std::uint32_t>(face.toInt()));
    }
    const QJsonArray color = entry.value().toObject()["color"].toArray();
    if (!color.isEmpty()) {
      const auto channel = [&](int i) { return static_cast<std::uint8_t>(color[i].toInt()); };
      label.color = Rgba8{channel(0), channel(1), channel(2), 255};
    }
  }
  return labels;
}

std::string json(const std::string& labels)
{
  return "{\"format\": \"mesh_labels\", \"version\": 1,\n\"labels\": [" + labels + "]}";
}

}  // namespace

TEST(LabelFiles, what_is_written_is_read_again)
{
  std::mt19937 random(1);
  for (int round = 0; round < 500; ++round) {
    const std::size_t face_count = 1 + random() % 50;
    const LabelFile file = {"uuid \"1\"", randomLabels(random, face_count)};
    const LabelFile from_json = labelsFromJson(labelsToJson(file, face_count), face_count);
    EXPECT_EQ(from_json.uuid, file.uuid);
    ASSERT_TRUE(same(from_json.labels, file.labels)) << labelsToJson(file, face_count);
    ASSERT_TRUE(same(labelsFromCsv(labelsToCsv(file.labels), face_count), file.labels))
        << labelsToCsv(file.labels);
  }
}

TEST(LabelFiles, hold_all_names_that_labels_may_have)
{
  QFile cases(LABEL_NAMES);
  ASSERT_TRUE(cases.open(QIODevice::ReadOnly)) << LABEL_NAMES;
  LabelFile file;
  for (const auto& entry : QJsonDocument::fromJson(cases.readAll()).array()) {
    const QJsonObject one = entry.toObject();
    if (one["usable"].toBool()) {
      file.labels[one["label"].toString().toStdString()].faces = {1, 2};
    }
  }
  ASSERT_GE(file.labels.size(), 20u);
  EXPECT_TRUE(same(labelsFromJson(labelsToJson(file, 10), 10).labels, file.labels));
  EXPECT_TRUE(same(labelsFromCsv(labelsToCsv(file.labels), 10), file.labels));
}

/// Cases that mesh_tool has to read in the same way: mesh_msgs_hdf5/test/labels.
TEST(LabelFiles, are_read_and_written_as_by_mesh_tool)
{
  QFile cases(LABEL_FILES);
  ASSERT_TRUE(cases.open(QIODevice::ReadOnly)) << LABEL_FILES;
  const QJsonArray corpus = QJsonDocument::fromJson(cases.readAll()).array();
  ASSERT_GE(corpus.size(), 90);
  QTemporaryDir folder;
  const std::string path = folder.filePath("labels").toStdString();
  for (const auto& entry : corpus) {
    const QJsonObject one = entry.toObject();
    SCOPED_TRACE(one["name"].toString().toStdString());
    const QString text = one["text"].toString();
    const QByteArray bytes = one.contains("encoding") ? text.toLatin1() : text.toUtf8();
    std::ofstream(path, std::ios::binary).write(bytes.data(), bytes.size());
    if (one.contains("refused")) {
      const std::string said = reasonOf([&] { readLabelFile(path, 10); });
      EXPECT_EQ(said.rfind(path + ": ", 0), 0u) << said;
      EXPECT_NE(said.find(one["refused"].toString().toStdString()), std::string::npos) << said;
      continue;
    }
    LabelFile file;
    ASSERT_EQ(reasonOf([&] { file = readLabelFile(path, 10); }), "nothing was wrong");
    EXPECT_EQ(file.uuid, one["uuid"].toString().toStdString());
    EXPECT_TRUE(same(file.labels, labelsOf(one["labels"].toObject())));
    if (one["written"].toBool()) {
      EXPECT_EQ(file.uuid.empty() ? labelsToCsv(file.labels) : labelsToJson(file, 10),
                text.toStdString());
    }
  }
}

TEST(LabelFiles, are_those_of_mesh_tool)
{
  LabelFile file;
  file.uuid = "u";
  file.labels["tree_1"] = {{1, 2, 3, 7}, Rgba8{255, 0, 16, 255}};
  file.labels["wall"] = {{}, std::nullopt};
  EXPECT_EQ(labelsToCsv(file.labels),
            "label,class,instance,color,first_face,last_face\n"
            "tree_1,tree,1,#ff0010,1,3\ntree_1,tree,1,#ff0010,7,7\nwall,wall,,,,\n");
  EXPECT_EQ(labelsToJson(file, 10),
            "{\"format\": \"mesh_labels\", \"version\": 1, \"uuid\": \"u\", \"faces\": 10,\n"
            " \"labels\": [\n"
            "  {\"label\": \"tree_1\", \"class\": \"tree\", \"instance\": \"1\", "
            "\"color\": [255, 0, 16], \"faces\": [1, 2, 3, 7]},\n"
            "  {\"label\": \"wall\", \"class\": \"wall\", \"instance\": \"\", "
            "\"color\": null, \"faces\": []}\n ]}\n");
}

TEST(LabelFiles, of_others_are_read)
{
  const FileLabels labels = labelsFromCsv(
      "first_face ; label;color\r\n9;tree_1;\r\n\r\n2; tree_1;#0000ff\r\n3;tree_1;#00FF00\r\n", 10);
  EXPECT_EQ(labels.at("tree_1").faces, (std::vector<std::uint32_t>{3, 9}));
  EXPECT_EQ(labels.at("tree_1").color, (Rgba8{0, 255, 0, 255}));
  EXPECT_EQ(labels.at(" tree_1").faces, (std::vector<std::uint32_t>{2}));
  const LabelFile file = labelsFromJson(json("{\"label\": \"a\", \"faces\": [3, 1, 3]}"), 10);
  EXPECT_EQ(file.labels.at("a").faces, (std::vector<std::uint32_t>{1, 3}));
}

TEST(LabelFiles, json_that_is_wrong_is_refused_with_the_place)
{
  expectReason("{\n\n\"a\": }", true, "line 3 is no JSON");
  expectReason("", true, "line 1 is no JSON");
  expectReason("[]", true, "\"format\"");
  expectReason("{\"format\": \"mesh_labels\", \"version\": 2}", true, "version 1");
  expectReason("{\"format\": \"mesh_labels\", \"version\": 1}", true, "no list \"labels\"");
  expectReason("{\"format\": \"mesh_labels\", \"version\": 1, \"faces\": 11, \"labels\": []}", true,
               "a mesh of 11 faces, this one has 10");
  expectReason(json("7"), true, "labels[0] has no text");
  expectReason(json("{\"label\": 7, \"faces\": []}"), true, "labels[0] has no text");
  expectReason(json("{\"label\": \"a\"}"), true, "no list \"faces\"");
  expectReason(json("{\"label\": \"\", \"faces\": []}"), true, "needs a name");
  expectReason(json("{\"label\": \"a/b\", \"faces\": []}"), true, "contains a slash");
  expectReason(json("{\"label\": \"a\\u0007\", \"faces\": []}"), true,
               "contains a control character");
  for (const char* face : {"10", "-1", "0.5", "\"1\"", "1e99", "null"}) {
    expectReason(json("{\"label\": \"a\", \"faces\": [0, " + std::string(face) + "]}"), true,
                 "labels[0], 'a': faces[1] is no face");
  }
  const std::string good = "{\"label\": \"a\", \"faces\": []}";
  expectReason(json(good + "," + good), true, "labels[1], 'a' comes twice");
  for (const char* color :
       {"1", "[1, 2]", "[1, 2, 3, 4]", "[1, 2, 256]", "[1, 2, -1]", "[1, 2, 0.5]"}) {
    expectReason(json("{\"label\": \"a\", \"faces\": [], \"color\": " + std::string(color) + "}"),
                 true, "labels[0], 'a': the color");
  }
}

TEST(LabelFiles, csv_that_is_wrong_is_refused_with_the_line)
{
  const std::string head = "label,color,first_face,last_face\n";
  expectReason("", false, "empty");
  expectReason("label,faces\n", false, "line 1 does not name");
  expectReason(head + "a,,1,2\nb,,3,10\n", false, "line 3: '10' is no face");
  expectReason(head + "a,,-1,2\n", false, "line 2: '-1' is no face");
  expectReason(head + "a,,,2\n", false, "line 2: '' is no face");
  expectReason(head + "a,,99999999999999999999,\n", false, "is no face");
  expectReason(head + "a,,5,4\n", false, "line 2: the last face comes before");
  expectReason(head + ",,1,2\n", false, "line 2: a label needs a name");
  expectReason(head + "a,red,1,2\n", false, "line 2: 'red' is no color");
  expectReason(head + "a,#112233,1,2\na,#112234,3,4\n", false, "line 3: label 'a' has two colors");
  expectReason(head + "a,,0,9\na,,0,9\n", false, "line 3: label 'a' has faces twice");
  expectReason(head + "\"a,,0,9\n", false, "line 2: a quotation mark has no end");
  expectReason(head + "\"a\"b,,0,9\n", false, "line 2: there is text behind");
}

TEST(LabelFiles, are_written_as_a_whole_and_refused_by_name)
{
  QTemporaryDir folder;
  const std::string path = folder.filePath("labels").toStdString();
  LabelFile file;
  file.uuid = "u";
  file.labels["tree_1"] = {{1, 2}, std::nullopt};
  for (const char* suffix : {".csv", ".CSV", ".json"}) {
    writeLabelFile(path + suffix, file, 10);
    EXPECT_TRUE(same(readLabelFile(path + suffix, 10).labels, file.labels)) << suffix;
    EXPECT_EQ(reasonOf([&] { readLabelFile(path + suffix, 2); }).rfind(path + suffix + ": ", 0),
              0u);
  }
  std::ofstream(path + ".csv") << "\xEF\xBB\xBFlabel,first_face\na,3\n";
  EXPECT_EQ(readLabelFile(path + ".csv", 10).labels.count("a"), 1u) << "as spreadsheets write it";
  const std::string missing = reasonOf([&] { readLabelFile(path + ".no", 10); });
  EXPECT_EQ(missing.rfind(path + ".no: it cannot be read", 0), 0u) << missing;
  EXPECT_NE(reasonOf([&] { readLabelFile("/dev/zero", 10); }).find("no file"), std::string::npos);
  const std::string nowhere = reasonOf([&] { writeLabelFile(path + "/x.csv", file, 10); });
  EXPECT_EQ(nowhere.rfind(path + "/x.csv: it cannot be written", 0), 0u) << nowhere;
}
