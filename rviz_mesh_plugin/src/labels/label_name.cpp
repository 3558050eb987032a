#include "labels/label_name.h"

#include <algorithm>
#include <cstdint>
#include <iomanip>
#include <sstream>

#include <boost/locale/utf.hpp>

namespace rviz_mesh_plugin {
namespace {

constexpr std::size_t MAX_BYTES = 255;  // labels become names of files and HDF5 datasets
constexpr std::size_t MAX_DIGITS = 9;   // of instances that are counted

/// Calls back with each character of UTF-8; false: the text is none, from here on.
template <class Visit>
bool visitCharacters(const std::string& text, const Visit& visit)
{
  namespace utf = boost::locale::utf;
  for (auto at = text.begin(); at != text.end();) {
    const utf::code_point point = utf::utf_traits<char>::decode(at, text.end());
    if (point == utf::illegal || point == utf::incomplete) {
      return false;
    }
    visit(point);
  }
  return true;
}

bool isControl(std::uint32_t character)
{
  return character < 0x20 || (character >= 0x7f && character <= 0x9f) || character == 0x2028 ||
         character == 0x2029;
}

/// Whether it turns the direction of what follows, or is dropped by those who read text: with it,
/// one name looks like another.
bool isDisguise(std::uint32_t character)
{
  return (character >= 0x202a && character <= 0x202e) ||
         (character >= 0x2066 && character <= 0x2069) || character == 0xfeff;
}

std::string hexadecimal(std::uint32_t character)
{
  std::ostringstream stream;
  stream << std::uppercase << std::hex << std::setw(4) << std::setfill('0') << character;
  return stream.str();
}

bool isDigit(char c)
{
  return c >= '0' && c <= '9';
}

bool isNumber(const std::string& text)
{
  return !text.empty() && text.size() <= MAX_DIGITS &&
         std::all_of(text.begin(), text.end(), isDigit);
}

/// The run of digits from @a start, without zeros at its front; @a start goes behind it.
std::string takeNumber(const std::string& text, std::size_t& start)
{
  while (start + 1 < text.size() && text[start] == '0' && isDigit(text[start + 1])) {
    ++start;
  }
  const std::size_t first = start;
  while (start < text.size() && isDigit(text[start])) {
    ++start;
  }
  return text.substr(first, start - first);
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

bool isUtf8(const std::string& text)
{
  return visitCharacters(text, [](std::uint32_t /*point*/) {});
}

std::string labelFault(const std::string& label)
{
  if (label.size() > MAX_BYTES) {
    return "has " + std::to_string(label.size()) + " bytes";
  }
  std::vector<std::uint32_t> characters;
  const bool is_utf8 =
      visitCharacters(label, [&](std::uint32_t point) { characters.push_back(point); });
  if (is_utf8 && std::any_of(characters.begin(), characters.end(), isControl)) {
    return "contains a control character";
  }
  if (label.find('/') != std::string::npos) {
    return "contains a slash";
  }
  if (label == "." || label == "..") {
    return "is no name";
  }
  if (!is_utf8) {
    return "is no UTF-8";
  }
  const auto disguise = std::find_if(characters.begin(), characters.end(), isDisguise);
  if (disguise != characters.end()) {
    return "contains U+" + hexadecimal(*disguise) + ", which makes it look like another";
  }
  return {};
}

std::string whyNoLabel(const std::string& label)
{
  const std::string fault = labelFault(label);
  if (!label.empty() && fault.empty()) {
    return {};
  }
  return (label.empty() ? "a label needs a name" : "the name of the label " + fault) +
         ": call it like tree_1, class and instance, in up to " + std::to_string(MAX_BYTES) +
         " bytes";
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

bool LabelLess::operator()(const std::string& a, const std::string& b) const
{
  std::size_t i = 0;
  std::size_t j = 0;
  while (i < a.size() && j < b.size()) {
    if (isDigit(a[i]) && isDigit(b[j])) {
      const std::string m = takeNumber(a, i);
      const std::string n = takeNumber(b, j);
      if (m != n) {
        return m.size() != n.size() ? m.size() < n.size() : m < n;
      }
    } else if (a[i] != b[j]) {
      return static_cast<unsigned char>(a[i]) < static_cast<unsigned char>(b[j]);
    } else {
      ++i;
      ++j;
    }
  }
  if (a.size() - i != b.size() - j) {
    return a.size() - i < b.size() - j;
  }
  return a < b;  // equal but for zeros: tree_01 and tree_1
}

}  // namespace rviz_mesh_plugin
