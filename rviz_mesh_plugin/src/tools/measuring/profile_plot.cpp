#include "tools/measuring/profile_plot.h"

#include <algorithm>
#include <cmath>

#include <QPainter>
#include <QPainterPath>

namespace rviz_mesh_plugin {
namespace {

constexpr int LEFT = 46, RIGHT = 10, TOP = 8, BOTTOM = 20;

/// 1, 2 or 5 times a power of ten, so that there are about so many of them in a span.
double stepOf(double span, double count)
{
  const double rough = span / count;
  const double power = std::pow(10.0, std::floor(std::log10(rough)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= rough) {
      return factor * power;
    }
  }
  return 10.0 * power;
}

QString tick(double value, double step)
{
  const int decimals = std::max(0, static_cast<int>(-std::floor(std::log10(step) + 1e-9)));
  return QString::number(std::abs(value) < 1e-9 * step ? 0.0 : value, 'f', decimals);
}

}  // namespace

ProfilePlot::ProfilePlot(QWidget* parent) : QWidget(parent)
{
  setMinimumHeight(120);
}

void ProfilePlot::show(const SurfaceProfile& profile)
{
  profile_ = profile;
  update();
}

void ProfilePlot::paintEvent(QPaintEvent* /*event*/)
{
  QPainter canvas(this);
  canvas.fillRect(rect(), palette().base());
  if (profile_.pieces.empty() || !(profile_.length > 0.0)) {
    return;
  }
  SurfaceProfile::Heights heights = profile_.heights();
  // A level line lies in the middle, and is not drawn as if it were rough.
  const double span = std::max(heights.highest - heights.lowest, 0.01 * profile_.length);
  const double low = 0.5 * (heights.lowest + heights.highest) - 0.55 * span;
  const double high = low + 1.1 * span;
  const QRectF area(LEFT, TOP, width() - LEFT - RIGHT, height() - TOP - BOTTOM);
  const auto x = [&](double s) { return area.left() + s / profile_.length * area.width(); };
  const auto y = [&](double z) { return area.bottom() - (z - low) / (high - low) * area.height(); };
  for (const auto& gap : profile_.gaps()) {
    canvas.fillRect(QRectF(x(gap.begin), area.top(), x(gap.end) - x(gap.begin), area.height()),
                    QBrush(QColor(200, 60, 60, 120), Qt::BDiagPattern));
  }
  const QColor faint(128, 128, 128, 90);
  const double across = stepOf(profile_.length, std::max(2.0, area.width() / 60.0));
  for (double s = 0.0; s <= profile_.length * (1.0 + 1e-9); s += across) {
    canvas.setPen(faint);
    canvas.drawLine(QPointF(x(s), area.top()), QPointF(x(s), area.bottom()));
    canvas.setPen(palette().text().color());
    canvas.drawText(QRectF(x(s) - 30, area.bottom() + 2, 60, BOTTOM - 2),
                    Qt::AlignHCenter | Qt::AlignTop, tick(s, across));
  }
  const double up = stepOf(high - low, std::max(2.0, area.height() / 28.0));
  for (double z = std::ceil(low / up) * up; z <= high; z += up) {
    canvas.setPen(faint);
    canvas.drawLine(QPointF(area.left(), y(z)), QPointF(area.right(), y(z)));
    canvas.setPen(palette().text().color());
    canvas.drawText(QRectF(0, y(z) - 10, LEFT - 4, 20), Qt::AlignRight | Qt::AlignVCenter,
                    tick(z, up));
  }
  canvas.drawText(QRectF(area.right() - 80, area.top(), 78, 18), Qt::AlignRight, "z, m");
  canvas.setRenderHint(QPainter::Antialiasing);
  canvas.setPen(QPen(QColor(0, 140, 60), 1.6));
  for (const auto& piece : profile_.pieces) {
    QPainterPath path(QPointF(x(piece[0].distance), y(piece[0].z)));
    for (const SurfaceProfile::Point& point : piece) {
      path.lineTo(x(point.distance), y(point.z));
    }
    canvas.drawPath(path);
  }
}

}  // namespace rviz_mesh_plugin
