#include "labels/label_order.h"

#include <cstddef>

namespace rviz_mesh_plugin {
namespace {

bool isDigit(char c)
{
  return c >= '0' && c <= '9';
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
