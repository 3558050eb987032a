#pragma once

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

}  // namespace rviz_mesh_plugin
