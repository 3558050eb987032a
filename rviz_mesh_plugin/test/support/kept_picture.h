#pragma once

#include <cstdlib>

#include <QString>
#include <QWidget>

/// For people to look at, where the test run keeps pictures.
inline void keep(QWidget* widget, const char* name)
{
  const char* folder = std::getenv("OSMESA_HARNESS_OUT");
  if (folder) {
    widget->grab().save(QString(folder) + "/" + name + ".png");
  }
}
