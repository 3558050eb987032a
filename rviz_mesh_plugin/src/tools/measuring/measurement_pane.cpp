#include "tools/measuring/measurement_pane.h"

#include <QButtonGroup>
#include <QFileDialog>
#include <QFileInfo>
#include <QHBoxLayout>
#include <QHeaderView>
#include <QLabel>
#include <QMessageBox>
#include <QPushButton>
#include <QShortcut>
#include <QSignalBlocker>
#include <QTableWidget>
#include <QVBoxLayout>

#include "measurement/measurement_files.h"
#include "tools/measuring/profile_plot.h"

namespace rviz_mesh_plugin {
namespace {

enum Column
{
  NUMBER,
  KIND,
  VALUE,
  DETAILS,
  COLUMN_COUNT
};

QString detailsOf(const Measurement& measurement)
{
  const QString text = QString::fromStdString(measurement.details());
  return measurement.stale ? "the mesh is gone; " + text : text;
}

}  // namespace

MeasurementPane::MeasurementPane(MeasurementList& list,
                                 const std::function<void(MeasurementKind)>& choose)
    : list_(list)
{
  setObjectName("Measurements");
  auto* layout = new QVBoxLayout(this);
  auto* top = new QHBoxLayout;
  kinds_ = new QButtonGroup(this);
  const char* const tips[] = {
      "Two points: straight, along the surface, height difference and slope",
      "The corners of an outline, closed by Enter, a double click or a click at the first one",
      "Two points: the height of the surface below the line between them"};
  for (const auto kind :
       {MeasurementKind::DISTANCE, MeasurementKind::AREA, MeasurementKind::PROFILE}) {
    auto* button = new QPushButton(nameOf(kind));
    button->setCheckable(true);
    button->setToolTip(tips[static_cast<int>(kind)]);
    kinds_->addButton(button, static_cast<int>(kind));
    top->addWidget(button);
    connect(button, &QPushButton::clicked, this, [choose, kind] { choose(kind); });
  }
  layout->addLayout(top);
  table_ = new QTableWidget(0, COLUMN_COUNT);
  table_->setHorizontalHeaderLabels({"No.", "Kind", "Value", "Details"});
  table_->verticalHeader()->hide();
  table_->horizontalHeader()->setStretchLastSection(true);
  table_->setSelectionBehavior(QAbstractItemView::SelectRows);
  table_->setSelectionMode(QAbstractItemView::ExtendedSelection);
  table_->setEditTriggers(QAbstractItemView::NoEditTriggers);
  table_->setWordWrap(false);
  connect(table_, &QTableWidget::itemSelectionChanged, this, &MeasurementPane::showSelected);
  layout->addWidget(table_, 1);
  details_ = new QLabel;
  details_->setWordWrap(true);
  details_->setTextInteractionFlags(Qt::TextSelectableByMouse);
  layout->addWidget(details_);
  plot_ = new ProfilePlot;
  layout->addWidget(plot_);
  createButtons();
  report_ = new QLabel;
  report_->setWordWrap(true);
  layout->addWidget(report_);
  refresh();
}

void MeasurementPane::createButtons()
{
  auto* layout = static_cast<QVBoxLayout*>(this->layout());
  const auto button = [&](const char* text, const char* tip, QHBoxLayout* row,
                          const std::function<void()>& act) {
    auto* made = new QPushButton(text);
    made->setToolTip(tip);
    row->addWidget(made);
    connect(made, &QPushButton::clicked, this, act);
    return made;
  };
  auto* first = new QHBoxLayout;
  remove_ = button("Delete", "Takes away what is selected in the list (Del)", first,
                   [this] { Q_EMIT removeAsked(selected()); });
  clear_ = button("Delete All…", "Takes away all measurements", first, [this] { askToClear(); });
  auto* second = new QHBoxLayout;
  export_ = button("Export…", "Writes all measurements to a CSV file, a row for each", second,
                   [this] { askFile(false); });
  export_profile_ =
      button("Export Profile…", "Writes the points of the selected profile to a CSV file", second,
             [this] { askFile(true); });
  layout->addLayout(first);
  layout->addLayout(second);
  auto* key = new QShortcut(QKeySequence::Delete, table_);
  key->setContext(Qt::WidgetShortcut);
  connect(key, &QShortcut::activated, remove_, &QPushButton::click);
}

void MeasurementPane::refresh()
{
  const auto chosen = selected();
  const auto& all = list_.all();
  {
    const QSignalBlocker blocker(table_);
    const int before = table_->rowCount();
    table_->clearSelection();
    table_->setRowCount(static_cast<int>(all.size()));
    for (int row = 0; row < table_->rowCount(); ++row) {
      const Measurement& measurement = all[static_cast<std::size_t>(row)];
      const QString texts[] = {QString::number(measurement.number), nameOf(measurement.kind),
                               QString::fromStdString(measurement.value()), detailsOf(measurement)};
      for (int column = 0; column < COLUMN_COUNT; ++column) {
        auto* item = new QTableWidgetItem(texts[column]);
        item->setToolTip(texts[column]);
        item->setData(Qt::UserRole, measurement.number);
        if (measurement.stale) {
          item->setForeground(palette().color(QPalette::Disabled, QPalette::Text));
        }
        table_->setItem(row, column, item);
        const bool was =
            std::find(chosen.begin(), chosen.end(), measurement.number) != chosen.end();
        const bool is_new = row >= before && row + 1 == table_->rowCount();
        if (is_new && column == 0) {
          table_->clearSelection();
        }
        item->setSelected(is_new || (was && before >= table_->rowCount()));
      }
    }
    for (const int column : {NUMBER, KIND, VALUE}) {
      table_->resizeColumnToContents(column);
    }
    if (table_->rowCount() > before) {
      table_->scrollToBottom();
    }
  }
  showSelected();
}

void MeasurementPane::showKind(MeasurementKind kind)
{
  kinds_->button(static_cast<int>(kind))->setChecked(true);
}

std::vector<std::uint32_t> MeasurementPane::selected() const
{
  std::vector<std::uint32_t> numbers;
  for (int row = 0; row < table_->rowCount(); ++row) {
    const QTableWidgetItem* item = table_->item(row, NUMBER);
    if (item && item->isSelected()) {
      numbers.push_back(item->data(Qt::UserRole).toUInt());
    }
  }
  return numbers;
}

void MeasurementPane::showSelected()
{
  const auto numbers = selected();
  const Measurement* const one = numbers.size() == 1 ? list_.find(numbers[0]) : nullptr;
  details_->setText(one ? detailsOf(*one) : QString());
  const bool profile = one && one->kind == MeasurementKind::PROFILE &&
                       one->state == Measurement::DONE && !one->result.profile.pieces.empty();
  plot_->setVisible(profile);
  if (profile) {
    plot_->show(one->result.profile);
  }
  remove_->setEnabled(!numbers.empty());
  clear_->setEnabled(!list_.all().empty());
  export_->setEnabled(!list_.all().empty());
  export_profile_->setEnabled(profile);
}

void MeasurementPane::askToClear()
{
  auto* box = new QMessageBox(QMessageBox::Question, "Delete All",
                              QString("Take away all %1 measurements? They cannot be brought back.")
                                  .arg(list_.all().size()),
                              QMessageBox::Ok | QMessageBox::Cancel, this);
  box->setAttribute(Qt::WA_DeleteOnClose);
  connect(box, &QMessageBox::accepted, this, &MeasurementPane::clearAsked);
  box->open();
}

/// The dialog asks before it takes a file that is there.
void MeasurementPane::askFile(bool profile)
{
  auto* dialog = new QFileDialog(this, profile ? "Export Profile" : "Export Measurements");
  dialog->setAttribute(Qt::WA_DeleteOnClose);
  dialog->setNameFilters({"CSV (*.csv)"});
  dialog->setAcceptMode(QFileDialog::AcceptSave);
  dialog->setDefaultSuffix("csv");
  // Others ask about the name as it is typed, without the suffix.
  dialog->setOption(QFileDialog::DontUseNativeDialog);
  connect(dialog, &QFileDialog::fileSelected, this,
          [this, profile](const QString& path) { write(path.toStdString(), profile); });
  dialog->open();
}

void MeasurementPane::write(const std::string& path, bool profile)
{
  const auto numbers = selected();
  const Measurement* const one = numbers.size() == 1 ? list_.find(numbers[0]) : nullptr;
  if (writing_.isRunning()) {
    report_->setText("A file is still being written: export again when it is there.");
  } else if (profile && (!one || one->stale || one->state != Measurement::DONE ||
                         one->result.profile.pieces.empty())) {
    report_->setText("No profile with points is selected any more: select one, and export again.");
  } else {
    // It was there, and the user has said to replace it; else none is replaced.
    const bool replace = QFileInfo::exists(QString::fromStdString(path));
    report_->setText("Writing " + QString::fromStdString(path) + "…");
    try {
      writing_.start([path, replace, profile,
                      measurements =
                          profile ? std::vector{*one} : list_.all()](const Cancellation&) {
        writeCsv(path, profile ? profileToCsv(measurements[0]) : measurementsToCsv(measurements),
                 replace);
        return (profile
                    ? "The profile was"
                    : std::to_string(measurements.size()) +
                          (measurements.size() == 1 ? " measurement was" : " measurements were")) +
               (" written to " + path);
      });
    } catch (const std::exception& error) {  // no thread
      report_->setText(QString::fromStdString(path + " cannot be written: " + error.what()));
    }
  }
}

void MeasurementPane::work()
{
  if (const auto outcome = writing_.take()) {
    report_->setText(QString::fromStdString(outcome->result ? *outcome->result : outcome->error));
  }
}

}  // namespace rviz_mesh_plugin
