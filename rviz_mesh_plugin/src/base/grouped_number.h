#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <QLocale>
#include <QString>

namespace rviz_mesh_plugin {

/// Numbers are grouped as the user's locale does it, and where that is none ("C"), as in English.
inline QLocale groupingLocale()
{
  const QLocale locale;
  return locale.language() == QLocale::C ? QLocale(QLocale::English) : locale;
}

/// "1,234,567"
inline QString groupedNumber(std::uint64_t number)
{
  return groupingLocale().toString(static_cast<qulonglong>(number));
}

/// "1,234.50"
inline QString groupedNumber(double number, int decimals)
{
  return groupingLocale().toString(number, 'f', decimals);
}

/// With four digits or more: "0.001234", "2.050", "1,234,568"
inline QString measuredNumber(double number)
{
  constexpr int DIGITS = 4, MOST_DECIMALS = 9;
  const double size = std::abs(number);
  const int before = size > 0.0 ? 1 + static_cast<int>(std::floor(std::log10(size))) : 1;
  return groupedNumber(number, std::clamp(DIGITS - before, 0, MOST_DECIMALS));
}

}  // namespace rviz_mesh_plugin
