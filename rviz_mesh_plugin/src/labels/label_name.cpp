#include "labels/label_name.h"

#include <algorithm>

#include <QChar>
#include <QString>
#include <QVector>

namespace rviz_mesh_plugin {
namespace {

constexpr std::size_t MAX_BYTES = 255;  // as in map files
constexpr std::size_t MAX_DIGITS = 9;   // of instances that are counted

bool isPrintable(const QString& text)
{
  const QVector<uint> letters = text.toUcs4();
  return std::all_of(letters.begin(), letters.end(), [](uint letter) {
    const QChar::Category category = QChar::category(letter);
    const bool separator = category == QChar::Separator_Line ||
                           category == QChar::Separator_Space ||
                           category == QChar::Separator_Paragraph;
    return QChar::isPrint(letter) && (letter == ' ' || !separator);
  });
}

bool isNumber(const std::string& text)
{
  return !text.empty() && text.size() <= MAX_DIGITS &&
         std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
}

}  // namespace

std::string labelClass(const std::string& label)
{
  return label.substr(0, label.find('_'));
}

std::string labelInstance(const std::string& label)
{
  const std::size_t underscore = label.find('_');
  return underscore == std::string::npos ? std::string() : label.substr(underscore + 1);
}

std::string joinLabel(const std::string& label_class, const std::string& instance)
{
  return instance.empty() ? label_class : label_class + "_" + instance;
}

std::string whyNoLabel(const std::string& label)
{
  const std::string hint = ": call it like tree_1, class and instance";
  if (label.empty()) {
    return "a label needs a name" + hint;
  }
  if (label.size() > MAX_BYTES) {
    return "the name of a label has at most " + std::to_string(MAX_BYTES) + " bytes" + hint;
  }
  const QString text = QString::fromStdString(label);
  if (text.toStdString() != label) {
    return "the name of a label has to be UTF-8" + hint;
  }
  if (label.find('/') != std::string::npos || label == "." || label == ".." || !isPrintable(text)) {
    return "the name of a label has no slash and no control character" + hint;
  }
  return {};
}

std::string nextInstance(const std::string& label_class, const std::vector<std::string>& labels)
{
  unsigned long next = 1;
  for (const std::string& label : labels) {
    const std::string instance = labelInstance(label);
    if (labelClass(label) == label_class && isNumber(instance)) {
      next = std::max(next, std::stoul(instance) + 1);
    }
  }
  return std::to_string(next);
}

}  // namespace rviz_mesh_plugin
