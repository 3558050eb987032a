#pragma once

#include <string>
#include <vector>

namespace rviz_mesh_plugin {

/// The class of a label: "tree" of "tree_1", the whole of a text without underscore.
std::string labelClass(const std::string& label);

/// "1" of "tree_1": what follows the first underscore; empty where there is none.
std::string labelInstance(const std::string& label);

/// The label of a class and an instance; the class alone where the instance is empty.
std::string joinLabel(const std::string& label_class, const std::string& instance);

bool isUtf8(const std::string& text);

/// What makes a text unusable as a label: the end of a sentence that begins with the label; empty:
/// nothing. Whether it is empty is not asked. The rule of mesh_msgs' checks/label_name.py: tests
/// hold both to the same cases.
std::string labelFault(const std::string& label);

/// Why those who store labels would refuse this name, with the way out; empty where they take it.
std::string whyNoLabel(const std::string& label);

/// The first of 1, 2, 3, … that is above all numbered instances of the class.
std::string nextInstance(const std::string& label_class, const std::vector<std::string>& labels);

/// The order in which labels are listed and drawn: tree_2 before tree_10.
struct LabelLess
{
  bool operator()(const std::string& a, const std::string& b) const;
};

}  // namespace rviz_mesh_plugin
