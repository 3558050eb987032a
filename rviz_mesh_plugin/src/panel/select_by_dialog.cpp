#include "panel/select_by_dialog.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <QComboBox>
#include <QDialog>
#include <QDialogButtonBox>
#include <QFormLayout>
#include <QHBoxLayout>
#include <QLabel>
#include <QLineEdit>
#include <QPointer>
#include <QPushButton>
#include <QStackedWidget>
#include <QTimer>
#include <QVBoxLayout>

#include "base/grouped_number.h"
#include "base/vectors.h"
#include "label_editing/label_session.h"
#include "selection/face_criterion.h"
#include "tools/cluster_label_tool.h"

namespace rviz_mesh_plugin {
namespace {

constexpr int REFRESH = 100;  // milliseconds
constexpr double PI = 3.14159265358979323846;

/// From a number to another; what is left empty is no limit.
class RangeFields : public QWidget
{
 public:
  explicit RangeFields(QWidget* parent)
      : QWidget(parent),
        lower_(new QLineEdit(this)),
        upper_(new QLineEdit(this)),
        unit_(new QLabel(this))
  {
    auto* row = new QHBoxLayout(this);
    row->setContentsMargins(0, 0, 0, 0);
    row->addWidget(lower_, 1);
    row->addWidget(new QLabel("to", this));
    row->addWidget(upper_, 1);
    row->addWidget(unit_);
    lower_->setObjectName("lower");
    upper_->setObjectName("upper");
    for (QLineEdit* field : {lower_, upper_}) {
      field->setToolTip("Empty: no limit. The number in grey is where the mesh begins or ends.");
    }
  }

  void setUnit(const QString& unit)
  {
    if (unit_->text() != unit) {
      unit_->setText(unit);
    }
  }

  /// Shown where the fields are empty.
  void setExtremes(double lower, double upper)
  {
    lower_->setPlaceholderText(QString::number(lower, 'g', 5));
    upper_->setPlaceholderText(QString::number(upper, 'g', 5));
  }
  void forgetExtremes()
  {
    lower_->setPlaceholderText({});
    upper_->setPlaceholderText({});
  }

  /// @throw std::runtime_error for what is no number
  ValueRange range() const
  {
    ValueRange range;
    range.lower = numberOf(*lower_, range.lower);
    range.upper = numberOf(*upper_, range.upper);
    if (range.lower > range.upper) {
      throw std::runtime_error("nothing lies from " + lower_->text().toStdString() + " to " +
                               upper_->text().toStdString() + ": turn them round");
    }
    return range;
  }

 private:
  static double numberOf(const QLineEdit& field, double otherwise)
  {
    const QString text = field.text().trimmed();
    bool is_number = false;
    const double number = text.toDouble(&is_number);
    if (!text.isEmpty() && !(is_number && std::isfinite(number))) {
      throw std::runtime_error("'" + text.toStdString() +
                               "' is no number: write one like 0.35, or nothing for no limit");
    }
    return text.isEmpty() ? otherwise : number;
  }

  QLineEdit* lower_;
  QLineEdit* upper_;
  QLabel* unit_;
};

/// Offers these, and keeps what is chosen if it is among them.
void offer(QComboBox* box, const QStringList& items)
{
  QStringList now;
  for (int i = 0; i < box->count(); ++i) {
    now.append(box->itemText(i));
  }
  if (now != items) {
    const QString chosen = box->currentText();
    box->clear();
    box->addItems(items);
    box->setCurrentIndex(std::max(0, box->findText(chosen)));
  }
}

QLabel* note(const QString& text, QWidget* parent)
{
  auto* label = new QLabel(text, parent);
  label->setWordWrap(true);
  return label;
}

QString lethalText(const LayerInfo& info)
{
  const std::string rule = lethalRule(info);
  if (!rule.empty()) {
    return QString::fromStdString("L" + rule.substr(1));
  }
  return info.infinity == "lethal"
             ? QString("Lethal (+inf)")
             : QString("+inf (%1)").arg(QString::fromStdString(info.infinity));
}

class SelectByDialog : public QDialog
{
 public:
  SelectByDialog(QWidget* parent, ClusterLabelTool* tool, const LabelSession* session)
      : QDialog(parent), tool_(tool), session_(session)
  {
    setWindowTitle("Select Faces By");
    setAttribute(Qt::WA_DeleteOnClose);
    auto* layout = new QVBoxLayout(this);
    auto* top = new QFormLayout;
    kind_ = new QComboBox(this);
    kind_->setObjectName("kind");
    pages_ = new QStackedWidget(this);
    addLayerPage();
    addHeightPage();
    addSlopePage();
    addLabelPage();
    top->addRow("Select by:", kind_);
    layout->addLayout(top);
    layout->addWidget(pages_);
    combination_ = new QComboBox(this);
    combination_->setObjectName("combination");
    combination_->addItems({"Replace the selection", "Add to the selection",
                            "Take away from the selection", "Keep only these of the selection"});
    auto* bottom = new QFormLayout;
    bottom->addRow("And:", combination_);
    layout->addLayout(bottom);
    status_ = note({}, this);
    layout->addWidget(status_);
    auto* buttons = new QDialogButtonBox(QDialogButtonBox::Close, this);
    QPushButton* select = buttons->addButton("Select", QDialogButtonBox::ApplyRole);
    select->setDefault(true);
    layout->addWidget(buttons);
    connect(select, &QPushButton::clicked, this, [this] { press(); });
    connect(buttons, &QDialogButtonBox::rejected, this, &QDialog::close);
    connect(kind_, QOverload<int>::of(&QComboBox::currentIndexChanged), pages_,
            &QStackedWidget::setCurrentIndex);
    auto* timer = new QTimer(this);
    connect(timer, &QTimer::timeout, this, [this] { follow(); });
    timer->start(REFRESH);
    follow();
  }

 private:
  enum Kind
  {
    LAYER,
    HEIGHT,
    SLOPE,
    LABEL
  };

  QFormLayout* addPage(const QString& name)
  {
    auto* page = new QWidget(this);
    auto* form = new QFormLayout(page);
    form->setContentsMargins(0, 0, 0, 0);
    pages_->addWidget(page);
    kind_->addItem(name);
    return form;
  }

  void addLayerPage()
  {
    QFormLayout* form = addPage("Layer");
    layer_ = new QComboBox(this);
    layer_->setObjectName("layer");
    values_ = new QComboBox(this);
    values_->setObjectName("values");
    values_->addItems({"From ... to ...", "Lethal", "Unknown (NaN)"});
    costs_ = new RangeFields(this);
    costs_->setObjectName("costs");
    corners_ = new QComboBox(this);
    corners_->setObjectName("corners");
    corners_->addItems({"at all three corners of a face", "at one corner or more"});
    form->addRow("Layer:", layer_);
    form->addRow("Values:", values_);
    form->addRow("", costs_);
    form->addRow("", corners_);
    layer_note_ = note({}, this);
    form->addRow(layer_note_);
    connect(values_, QOverload<int>::of(&QComboBox::currentIndexChanged), this,
            [this] { followLayer(); });
    connect(layer_, &QComboBox::currentTextChanged, this, [this] { followLayer(); });
  }

  void addHeightPage()
  {
    QFormLayout* form = addPage("Height");
    heights_ = new RangeFields(this);
    heights_->setObjectName("heights");
    heights_->setUnit("m");
    form->addRow("Height:", heights_);
    height_note_ = note({}, this);
    form->addRow(height_note_);
  }

  void addSlopePage()
  {
    QFormLayout* form = addPage("Slope");
    slopes_ = new RangeFields(this);
    slopes_->setObjectName("slopes");
    slopes_->setUnit("°");
    slopes_->setExtremes(0.0, 180.0);
    form->addRow("Slope:", slopes_);
    form->addRow(
        note("Between the normal of a face and up in the fixed frame: 0° of a floor, 90° "
             "of a wall, 180° of a ceiling.",
             this));
  }

  void addLabelPage()
  {
    QFormLayout* form = addPage("Label");
    label_ = new QComboBox(this);
    label_->setObjectName("label");
    form->addRow("Label:", label_);
    label_note_ = note({}, this);
    form->addRow(label_note_);
  }

  std::optional<KnownLayer> chosenLayer() const
  {
    const auto found =
        std::find_if(layers_.begin(), layers_.end(), [this](const KnownLayer& layer) {
          return layer_->currentText() == QString::fromStdString(layer.name);
        });
    return found == layers_.end() ? std::nullopt : std::make_optional(*found);
  }

  /// Layers and labels come and go, and meshes move.
  void follow()
  {
    try {
      const std::optional<ShownMesh> shown = tool_ ? tool_->shownMesh() : std::nullopt;
      layers_ = shown ? tool_->layersOf(shown->mesh) : std::vector<KnownLayer>();
      QStringList layers, labels;
      for (const KnownLayer& layer : layers_) {
        layers.append(QString::fromStdString(layer.name));
      }
      const bool labelled = shown && session_->isOf(shown->mesh);
      if (labelled) {
        for (const std::string& label : session_->names()) {
          labels.append(QString::fromStdString(label));
        }
      }
      offer(layer_, layers);
      offer(label_, labels);
      label_note_->setText(labels.isEmpty() ? "The mesh has no labels." : "");
      followLayer();
      followHeights(shown);
      showStatus(shown.has_value());
    } catch (const std::exception& error) {
      status_->setText(QString("This went wrong: %1").arg(error.what()));
    }
  }

  void followLayer()
  {
    const auto layer = chosenLayer();
    const bool of_range = values_->currentIndex() == LayerCriterion::RANGE;
    costs_->setVisible(of_range);
    corners_->setVisible(!layer || !layer->layer->on_faces);
    if (!layer) {
      layer_note_->setText("No cost layer of the mesh has arrived: choose one in the display.");
      return;
    }
    const QString lethal = lethalText(layer->info);
    if (values_->itemText(LayerCriterion::LETHAL) != lethal) {
      values_->setItemText(LayerCriterion::LETHAL, lethal);
    }
    const CostSummary& summary = layer->layer->summary;
    costs_->setUnit(QString::fromStdString(layer->info.unit));
    if (summary.finite > 0) {
      costs_->setExtremes(summary.limits.lower, summary.limits.upper);
    } else {
      costs_->forgetExtremes();
    }
    QString text =
        QString("%1 values: %2 finite, %3 +inf, %4 unknown.")
            .arg(groupedNumber(layer->layer->costs.size()), groupedNumber(summary.finite),
                 groupedNumber(summary.lethal), groupedNumber(summary.unknown));
    if (layer->info.comparison == LayerInfo::OTHER) {
      text += " Which others are lethal does not follow from the values.";
    }
    layer_note_->setText(text);
  }

  void followHeights(const std::optional<ShownMesh>& shown)
  {
    if (!shown) {
      heights_->forgetExtremes();
      return;
    }
    const HeightCriterion height = heightIn(*shown);
    const Eigen::Vector3d up = vectorOf(height.up), lower = vectorOf(shown->mesh->lower),
                          upper = vectorOf(shown->mesh->upper);
    const double middle = up.dot(lower + upper) / 2.0 + height.offset;
    const double reach = up.cwiseAbs().dot(upper - lower) / 2.0;
    heights_->setExtremes(middle - reach, middle + reach);
    height_note_->setText(
        QString("Of the middle of a face, above the origin of the fixed frame %1.")
            .arg(tool_->fixedFrame()));
  }

  static HeightCriterion heightIn(const ShownMesh& shown)
  {
    HeightCriterion height;
    height.up = upInMesh(shown);
    height.offset = shown.position.z;
    return height;
  }

  void showStatus(bool has_mesh)
  {
    QString text;
    if (!tool_) {
      text = "The tool ClusterLabel is gone: add it with the + of the toolbar.";
    } else if (!problem_.empty()) {
      text = QString::fromStdString(problem_) + ".";
      text[0] = text[0].toUpper();
    } else if (!has_mesh) {
      text = "No mesh is shown: add and enable a TexturedMesh or Map3D display.";
    } else if (tool_->busy()) {
      text = "Looking for the faces ...";
    } else {
      const FaceSelection& selection = tool_->selection();
      text = selection.size() == 0
                 ? QString("No faces are selected.")
                 : QString("%1 of %2 faces are selected.")
                       .arg(groupedNumber(selection.count()), groupedNumber(selection.size()));
      if (asked_ && !tool_->message().empty()) {
        text += " Last: " + QString::fromStdString(tool_->message()) + ".";
      }
    }
    if (status_->text() != text) {
      status_->setText(text);
    }
  }

  FaceCriterion criterion(const ShownMesh& shown) const
  {
    switch (kind_->currentIndex()) {
      case LAYER: {
        const auto layer = chosenLayer();
        if (!layer) {
          throw std::runtime_error("no cost layer of the mesh has arrived");
        }
        LayerCriterion criterion(layer->layer, layer->info);
        criterion.values = static_cast<LayerCriterion::Values>(values_->currentIndex());
        criterion.all_corners = corners_->currentIndex() == 0;
        if (criterion.values == LayerCriterion::RANGE) {
          criterion.range = costs_->range();
        }
        return criterion;
      }
      case HEIGHT: {
        HeightCriterion criterion = heightIn(shown);
        criterion.range = heights_->range();
        return criterion;
      }
      case SLOPE: {
        const ValueRange degrees = slopes_->range();
        return SlopeCriterion{upInMesh(shown),
                              {degrees.lower * PI / 180.0, degrees.upper * PI / 180.0}};
      }
      default:
        if (label_->currentText().isEmpty() || !session_->isOf(shown.mesh)) {
          throw std::runtime_error("the mesh has no labels");
        }
        return ListCriterion{session_->faces(label_->currentText().toStdString())};
    }
  }

  void press()
  {
    problem_.clear();
    try {
      const std::optional<ShownMesh> shown = tool_ ? tool_->shownMesh() : std::nullopt;
      if (shown) {
        asked_ = true;
        problem_ = tool_->selectBy(shown->mesh, criterion(*shown),
                                   static_cast<Combination>(combination_->currentIndex()));
      }
    } catch (const std::exception& error) {
      problem_ = error.what();
    }
    follow();
  }

  const QPointer<ClusterLabelTool> tool_;
  const LabelSession* session_;
  std::vector<KnownLayer> layers_;
  std::string problem_;  ///< of what was asked for last; empty: none
  bool asked_ = false;
  QComboBox* kind_;
  QStackedWidget* pages_;
  QComboBox* layer_;
  QComboBox* values_;
  RangeFields* costs_;
  QComboBox* corners_;
  QLabel* layer_note_;
  RangeFields* heights_;
  QLabel* height_note_;
  RangeFields* slopes_;
  QComboBox* label_;
  QLabel* label_note_;
  QComboBox* combination_;
  QLabel* status_;
};

}  // namespace

void openSelectBy(QWidget* parent, ClusterLabelTool* tool, const LabelSession* session)
{
  (new SelectByDialog(parent, tool, session))->show();
}

}  // namespace rviz_mesh_plugin
