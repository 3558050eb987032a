#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#ifndef Q_MOC_RUN
#include "measurement/measurement_list.h"
#include "threads/background_task.h"
#endif

#include <QWidget>

class QButtonGroup;
class QLabel;
class QPushButton;
class QTableWidget;

namespace rviz_mesh_plugin {

class ProfilePlot;

/// The list of measurements, with what can be done with them. Files are written on a thread.
class MeasurementPane : public QWidget
{
  Q_OBJECT

 public:
  /// @param list outlives this
  /// @param choose is called with the kind that the user wants
  MeasurementPane(MeasurementList& list, const std::function<void(MeasurementKind)>& choose);

  /// To be called where they have changed.
  void refresh();
  void showKind(MeasurementKind kind);
  /// To be called often: tells what has become of a file.
  void work();

  /// Of the rows that are selected.
  std::vector<std::uint32_t> selected() const;

 Q_SIGNALS:
  void removeAsked(const std::vector<std::uint32_t>& numbers);
  void clearAsked();

 private:
  void createButtons();
  void askToClear();
  void askFile(bool profile);
  void write(const std::string& path, bool profile);
  void showSelected();

  MeasurementList& list_;
  QButtonGroup* kinds_;
  QTableWidget* table_;
  QLabel* details_;
  ProfilePlot* plot_;
  QPushButton* remove_;
  QPushButton* clear_;
  QPushButton* export_;
  QPushButton* export_profile_;
  QLabel* report_;
  BackgroundTask<std::string> writing_{"csv writing"};
};

}  // namespace rviz_mesh_plugin
