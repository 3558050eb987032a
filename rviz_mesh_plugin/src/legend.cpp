#include "rviz_mesh_plugin/legend.h"

#include <exception>
#include <utility>

#include "legend_row.h"

namespace rviz_mesh_plugin {

class Legend::Panel : public LegendPanel
{
 public:
  explicit Panel(LegendContent shown)
  {
    content = std::move(shown);
    LegendRow::instance().add(this);
  }
  ~Panel() { LegendRow::instance().remove(this); }
};

Legend::Legend() = default;
Legend::~Legend() = default;

void Legend::show(const std::string& layer, const std::string& unit, const CostColoring& coloring,
                  const CostLimits& limits)
{
  LegendContent content{layer, unit, coloring, limits};
  if (panel_ && panel_->content == content) {
    return;
  }
  if (panel_) {
    panel_->content = std::move(content);
    panel_->drawn_height = 0;
    return;
  }
  if (!error_.empty()) {
    return;  // OGRE has no overlays now, nor will it later.
  }
  try {
    panel_ = std::make_unique<Panel>(std::move(content));
  } catch (const std::exception& error) {  // Ogre::Exception, std::bad_alloc
    error_ = error.what();
  }
}

void Legend::hide()
{
  panel_.reset();
}

std::string Legend::error() const
{
  if (!panel_) {
    return error_;
  }
  return panel_->error.empty() && !panel_->has_room ? "the 3D view is too small for it"
                                                    : panel_->error;
}

}  // namespace rviz_mesh_plugin
