#pragma once

#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "base/mesh_data.h"

namespace rviz_mesh_plugin {

/// The labels that have a color of their own.
using OwnColors = std::map<std::string, Rgba8>;
using OwnColorsConstPtr = std::shared_ptr<const OwnColors>;

/// How a label is drawn.
struct LabelLook
{
  Rgba8 color{200, 200, 200, 255};
  bool visible = true;
};

inline bool operator==(const LabelLook& a, const LabelLook& b)
{
  return a.color == b.color && a.visible == b.visible;
}

/// By label.
using LabelLooks = std::map<std::string, LabelLook>;

/// Colors of labels: a label's own where it has one, else that of its class.
///
/// A class has the color that its name stands for, the same in every process. Of two classes whose
/// names stand for the same color, the one that is asked for later gets another one, which no other
/// class has as long as there are enough.
class LabelColors
{
 public:
  /// So many colors can be told apart; more classes share them.
  static constexpr std::size_t PALETTE_SIZE = 36;

  Rgba8 color(const std::string& label);
  Rgba8 classColor(const std::string& label_class);

  /// Gives these labels (null: none) colors of their own, and no others; returns the labels whose
  /// color is another one than before.
  std::vector<std::string> setOwn(const OwnColorsConstPtr& own);

  /// Forgets all labels and classes.
  void clear();

 private:
  OwnColorsConstPtr own_;
  std::map<std::string, std::size_t> classes_;  ///< to places in the palette
  std::set<std::size_t> used_;
};

}  // namespace rviz_mesh_plugin
