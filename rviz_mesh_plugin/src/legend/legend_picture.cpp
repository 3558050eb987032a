#include "legend/legend_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include <QFont>
#include <QFontMetrics>
#include <QPainter>
#include <QString>

#include "base/qt_colors.h"

namespace rviz_mesh_plugin {
namespace {

constexpr std::array<double, 3> FACTORS{1.0, 2.0, 5.0};

/// Ticks this much outside the limits, as a share of their distance, are there by rounding.
constexpr double TOLERANCE = 1e-6;

/// From these magnitudes on a label is written with an exponent.
constexpr double LEAST_PLAIN = 1e-3;
constexpr double GREATEST_PLAIN = 1e5;

std::string print(const char* format, int decimals, double value)
{
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), format, decimals, value);
  std::string label(text.data());
  // RViz may run in a locale with decimal commas; its properties have points all the same.
  std::replace(label.begin(), label.end(), ',', '.');
  return label;
}

/// All labels of one scale alike: with the decimals that @a step needs.
std::string labelOf(double value, double step, double greatest)
{
  if (std::abs(value) < 1e-3 * step) {
    return "0";
  }
  if (greatest >= GREATEST_PLAIN || step < LEAST_PLAIN) {
    const int digits = 1 + static_cast<int>(std::floor(std::log10(greatest)) -
                                            std::floor(std::log10(step) + TOLERANCE));
    return print("%.*g", std::min(std::max(digits, 1), 9), value);
  }
  const int decimals = -static_cast<int>(std::floor(std::log10(step) + TOLERANCE));
  return print("%.*f", std::max(decimals, 0), value);
}

std::vector<ScaleTick> linearTicks(double lower, double upper, std::size_t most)
{
  const double span = upper - lower;
  int exponent = static_cast<int>(std::floor(std::log10(span))) - 3;
  for (;; ++exponent) {
    for (const double factor : FACTORS) {
      const double step = factor * std::pow(10.0, exponent);
      const double first = std::ceil(lower / step - TOLERANCE);
      const double last = std::floor(upper / step + TOLERANCE);
      if (last - first + 1.0 > static_cast<double>(most)) {
        continue;
      }
      std::vector<ScaleTick> ticks;
      const double greatest = std::max(std::abs(lower), std::abs(upper));
      for (double i = first; i <= last; i += 1.0) {
        const double value = i * step;
        ticks.push_back({value, (value - lower) / span, labelOf(value, step, greatest)});
      }
      return ticks;
    }
  }
}

std::string logarithmicLabel(double value)
{
  if (value >= GREATEST_PLAIN || value < LEAST_PLAIN) {
    return print("%.*g", 1, value);
  }
  return print("%.*g", 6, value);
}

/// Ticks at each of the factors in every decade_step-th decade.
std::vector<ScaleTick> decadeTicks(double lower, double upper, int decade_step,
                                   std::size_t factor_count)
{
  std::vector<ScaleTick> ticks;
  const double from = std::log10(lower);
  const double span = std::log10(upper) - from;
  const int first = static_cast<int>(std::floor(from)) - 1;
  const int last = static_cast<int>(std::ceil(from + span));
  for (int decade = first; decade <= last; ++decade) {
    if (decade % decade_step != 0) {
      continue;
    }
    for (std::size_t i = 0; i < factor_count; ++i) {
      const double value = FACTORS[i] * std::pow(10.0, decade);
      const double position = (std::log10(value) - from) / span;
      if (position >= -TOLERANCE && position <= 1.0 + TOLERANCE) {
        ticks.push_back({value, position, logarithmicLabel(value)});
      }
    }
  }
  return ticks;
}

std::vector<ScaleTick> logarithmicTicks(double lower, double upper, std::size_t most)
{
  for (const std::size_t factor_count : {FACTORS.size(), std::size_t{1}}) {
    const std::vector<ScaleTick> ticks = decadeTicks(lower, upper, 1, factor_count);
    if (ticks.size() >= 3 && ticks.size() <= most) {
      return ticks;
    }
  }
  if (upper / lower <= 100.0) {  // Too few of them: evenly spaced values say more.
    std::vector<ScaleTick> ticks = linearTicks(lower, upper, most);
    for (ScaleTick& tick : ticks) {
      tick.position = std::log(tick.value / lower) / std::log(upper / lower);
    }
    return ticks;
  }
  int decade_step = 1;
  while (decadeTicks(lower, upper, decade_step, 1).size() > most) {
    ++decade_step;
  }
  return decadeTicks(lower, upper, decade_step, 1);
}

// In pixels of the screen.
constexpr int MARGIN = 8;
constexpr int FONT_SIZE = 12;
constexpr int LINE_HEIGHT = 16;
constexpr int BAR_WIDTH = 18;
constexpr int TICK_LENGTH = 4;
constexpr int GAP = 4;
constexpr int SWATCH_SIZE = 11;
constexpr int TICK_DISTANCE = 26;
constexpr int MAX_TEXT_WIDTH = 160;

const QColor BACKGROUND(0, 0, 0, 165);
const QColor FOREGROUND(255, 255, 255);
const QColor OUTLINE(190, 190, 190);

QFont legendFont()
{
  QFont font(QStringLiteral("Sans Serif"));
  font.setStyleHint(QFont::SansSerif);
  font.setPixelSize(FONT_SIZE);
  return font;
}

/// A color with what it stands for.
struct Swatch
{
  Rgba8 color;
  QString text;
  bool is_line = false;  ///< a mark on the bar, not a color
};

/// Where everything is, and what is written there.
struct Plan
{
  std::vector<QString> title;
  std::vector<Swatch> above, below;  ///< of the bar
  std::vector<ScaleTick> ticks;
  int width = 0;
  int bar_top = 0;
  int bar_height = 0;
};

QString number(double value)
{
  return QString::fromStdString(print("%.*g", 4, value));
}

/// Which values are lethal, beside +inf.
QString lethalText(const LayerInfo& info)
{
  const QString infinity = QString::fromStdString(info.infinity);
  if (!info.hasThreshold()) {
    return infinity;
  }
  return infinity + (info.comparison == LayerInfo::ABOVE ? " > " : " ≥ ") + number(info.threshold);
}

Plan makePlan(const LegendContent& content, int height, const QFontMetrics& metrics)
{
  Plan plan;
  plan.title.push_back(
      metrics.elidedText(QString::fromStdString(content.layer), Qt::ElideMiddle, MAX_TEXT_WIDTH));
  if (!content.unit.empty()) {
    plan.title.push_back(metrics.elidedText("[" + QString::fromStdString(content.unit) + "]",
                                            Qt::ElideRight, MAX_TEXT_WIDTH));
  }
  const CostColoring& coloring = content.coloring;
  if (coloring.mark_outside) {
    plan.above.push_back({coloring.above, QStringLiteral("above")});
    plan.below.push_back({coloring.below, QStringLiteral("below")});
  }
  if (content.of_costs) {
    plan.below.push_back({coloring.lethal, lethalText(content.info)});
  }
  if (std::isfinite(content.info.cost_limit)) {
    plan.below.push_back({{}, "limit " + number(content.info.cost_limit), true});
  }
  if (content.of_costs) {
    plan.below.push_back({coloring.unknown, QStringLiteral("unknown")});
  }
  const auto lines = static_cast<int>(plan.title.size() + plan.above.size());
  plan.bar_top = MARGIN + lines * LINE_HEIGHT + 2 * GAP;
  const int bar_bottom =
      height - MARGIN - static_cast<int>(plan.below.size()) * LINE_HEIGHT - 2 * GAP;
  plan.bar_height = std::max(bar_bottom - plan.bar_top, 1);
  plan.ticks = scaleTicks(coloring, content.limits,
                          static_cast<std::size_t>(std::max(plan.bar_height / TICK_DISTANCE, 2)));
  const int text_left = BAR_WIDTH + TICK_LENGTH + GAP;
  for (const QString& line : plan.title) {
    plan.width = std::max(plan.width, metrics.horizontalAdvance(line));
  }
  for (const ScaleTick& tick : plan.ticks) {
    const QString label = QString::fromStdString(tick.label);
    plan.width = std::max(plan.width, text_left + metrics.horizontalAdvance(label));
  }
  for (const std::vector<Swatch>* swatches : {&plan.above, &plan.below}) {
    for (const Swatch& swatch : *swatches) {
      plan.width = std::max(plan.width, text_left + metrics.horizontalAdvance(swatch.text));
    }
  }
  plan.width += 2 * MARGIN;
  return plan;
}

void drawText(QPainter& painter, int left, int middle, const QString& text)
{
  painter.setPen(FOREGROUND);
  painter.drawText(QRect(left, middle - LINE_HEIGHT / 2, 2 * MAX_TEXT_WIDTH, LINE_HEIGHT),
                   Qt::AlignLeft | Qt::AlignVCenter | Qt::TextSingleLine, text);
}

/// A line that is seen on all colors.
void drawMark(QPainter& painter, int left, int right, int y)
{
  painter.fillRect(QRect(left, y - 1, right - left + 1, 3), QColor(0, 0, 0));
  painter.fillRect(QRect(left, y, right - left + 1, 1), FOREGROUND);
}

void drawSwatches(QPainter& painter, int top, const std::vector<Swatch>& swatches)
{
  for (const Swatch& swatch : swatches) {
    const int middle = top + LINE_HEIGHT / 2;
    const QRect square(MARGIN + BAR_WIDTH - SWATCH_SIZE, middle - SWATCH_SIZE / 2, SWATCH_SIZE,
                       SWATCH_SIZE);
    if (swatch.is_line) {
      drawMark(painter, square.left(), square.right(), middle);
    } else {
      painter.fillRect(square.adjusted(-1, -1, 1, 1), OUTLINE);
      painter.fillRect(square, toQColor(swatch.color));
    }
    drawText(painter, MARGIN + BAR_WIDTH + TICK_LENGTH + GAP, middle, swatch.text);
    top += LINE_HEIGHT;
  }
}

/// Where a cost lies on the bar, 0 at its lower end; not within 0 to 1 where it is outside.
double heightOf(const LegendContent& content, double cost)
{
  const double lower = std::min(content.limits.lower, content.limits.upper);
  const double upper = std::max(content.limits.lower, content.limits.upper);
  if (lower == upper) {
    return cost == lower ? 0.5 : cost < lower ? -1.0 : 2.0;
  }
  return isLogarithmic(content.coloring, content.limits)
             ? (cost > 0.0 ? std::log(cost / lower) / std::log(upper / lower) : -1.0)
             : (cost - lower) / (upper - lower);
}

/// The color at a height of the bar, 0 at the least cost. Where all costs are equal, the lower half
/// has their color and the upper one that of greater ones.
Rgba8 barColor(const LegendContent& content, double height)
{
  const CostLimits& limits = content.limits;
  const CostColoring& coloring = content.coloring;
  if (coloring.mark_lethal && std::isfinite(coloring.least_lethal) &&
      height >= heightOf(content, coloring.least_lethal)) {
    return coloring.lethal;
  }
  if (limits.lower == limits.upper) {
    height = height <= 0.5 ? 0.0 : 1.0;
  }
  const bool backwards = (limits.lower > limits.upper) != content.coloring.inverted;
  return scaleColor(content.coloring.scale, static_cast<float>(backwards ? 1.0 - height : height));
}

void drawBar(QPainter& painter, const LegendContent& content, const Plan& plan, double pixel_ratio)
{
  const QRectF bar(MARGIN, plan.bar_top, BAR_WIDTH, plan.bar_height);
  painter.fillRect(bar.adjusted(-1, -1, 1, 1), OUTLINE);
  const int rows = std::max(static_cast<int>(plan.bar_height * pixel_ratio), 1);
  const double row_height = bar.height() / rows;
  for (int line = 0; line < rows; ++line) {
    const double height = rows == 1 ? 0.0 : 1.0 - static_cast<double>(line) / (rows - 1);
    painter.fillRect(QRectF(bar.left(), bar.top() + line * row_height, bar.width(), row_height),
                     toQColor(barColor(content, height)));
  }
  const auto row = [&](double height) {
    return plan.bar_top + static_cast<int>((1.0 - height) * (plan.bar_height - 1) + 0.5);
  };
  for (const float marked : {content.info.threshold, content.info.cost_limit}) {
    const double height = std::isfinite(marked) ? heightOf(content, marked) : -1.0;
    if (height >= 0.0 && height <= 1.0) {
      drawMark(painter, MARGIN - GAP, MARGIN + BAR_WIDTH, row(height));
    }
  }
  for (const ScaleTick& tick : plan.ticks) {
    const int y = row(tick.position);
    painter.fillRect(QRect(MARGIN + BAR_WIDTH + 1, y, TICK_LENGTH, 1), FOREGROUND);
    drawText(painter, MARGIN + BAR_WIDTH + TICK_LENGTH + GAP, y,
             QString::fromStdString(tick.label));
  }
}

}  // namespace

std::vector<ScaleTick> scaleTicks(const CostColoring& coloring, const CostLimits& limits,
                                  std::size_t most)
{
  const double lower = std::min(limits.lower, limits.upper);
  const double upper = std::max(limits.lower, limits.upper);
  if (lower == upper) {
    return {{lower, 0.5, print("%.*g", 6, lower)}};
  }
  most = std::max(most, std::size_t{2});
  std::vector<ScaleTick> ticks = isLogarithmic(coloring, limits)
                                     ? logarithmicTicks(lower, upper, most)
                                     : linearTicks(lower, upper, most);
  for (ScaleTick& tick : ticks) {
    tick.position = std::min(std::max(tick.position, 0.0), 1.0);
  }
  return ticks;
}

bool operator==(const LegendContent& a, const LegendContent& b)
{
  return a.layer == b.layer && a.unit == b.unit && a.coloring == b.coloring &&
         a.limits.lower == b.limits.lower && a.limits.upper == b.limits.upper && a.info == b.info &&
         a.of_costs == b.of_costs;
}

QImage drawLegend(const LegendContent& content, int height, double pixel_ratio)
{
  const QFont font = legendFont();
  const Plan plan = makePlan(content, height, QFontMetrics(font));
  QImage image(static_cast<int>(plan.width * pixel_ratio), static_cast<int>(height * pixel_ratio),
               QImage::Format_ARGB32_Premultiplied);
  image.fill(Qt::transparent);
  image.setDevicePixelRatio(pixel_ratio);
  QPainter painter{&image};
  painter.setFont(font);
  painter.setRenderHint(QPainter::Antialiasing);
  painter.setPen(Qt::NoPen);
  painter.setBrush(BACKGROUND);
  painter.drawRoundedRect(QRectF(0, 0, plan.width, height), GAP, GAP);
  painter.setRenderHint(QPainter::Antialiasing, false);
  int top = MARGIN;
  for (const QString& line : plan.title) {
    drawText(painter, MARGIN, top + LINE_HEIGHT / 2, line);
    top += LINE_HEIGHT;
  }
  drawSwatches(painter, top, plan.above);
  drawBar(painter, content, plan, pixel_ratio);
  drawSwatches(painter, plan.bar_top + plan.bar_height + 2 * GAP, plan.below);
  painter.end();
  return image.convertToFormat(QImage::Format_ARGB32);
}

}  // namespace rviz_mesh_plugin
