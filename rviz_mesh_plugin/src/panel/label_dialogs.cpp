#include "panel/label_dialogs.h"

#include <algorithm>
#include <set>

#include <QColorDialog>
#include <QComboBox>
#include <QDialogButtonBox>
#include <QFileDialog>
#include <QFormLayout>
#include <QInputDialog>
#include <QLabel>
#include <QLineEdit>
#include <QMessageBox>
#include <QPushButton>

#include "base/qt_colors.h"
#include "labels/label_name.h"

namespace rviz_mesh_plugin {
namespace {

constexpr std::size_t MOST_LISTED = 8;

/// Gone once it is closed.
template <class Dialog, class... Content>
Dialog* create(QWidget* parent, const QString& title, const Content&... content)
{
  auto* dialog = new Dialog(parent, content...);
  dialog->setAttribute(Qt::WA_DeleteOnClose);
  dialog->setWindowTitle(title);
  return dialog;
}

/// Class, instance, and why they cannot be taken.
class LabelDialog : public QDialog
{
 public:
  LabelDialog(QWidget* parent, const std::string& label, const std::vector<std::string>& labels)
      : QDialog(parent),
        labels_(labels),
        label_class_(new QComboBox(this)),
        instance_(new QLineEdit(this)),
        problem_(new QLabel(this)),
        buttons_(new QDialogButtonBox(QDialogButtonBox::Ok | QDialogButtonBox::Cancel, this))
  {
    std::set<std::string> classes;
    for (const std::string& other : labels) {
      classes.insert(labelClass(other));
    }
    for (const std::string& name : classes) {
      label_class_->addItem(QString::fromStdString(name));
    }
    label_class_->setEditable(true);
    label_class_->setEditText(QString::fromStdString(labelClass(label)));
    problem_->setWordWrap(true);
    auto* layout = new QFormLayout(this);
    layout->addRow("Class:", label_class_);
    layout->addRow("Instance:", instance_);
    layout->addRow(problem_);
    layout->addRow(buttons_);
    connect(buttons_, &QDialogButtonBox::accepted, this, &QDialog::accept);
    connect(buttons_, &QDialogButtonBox::rejected, this, &QDialog::reject);
    const bool suggests = label.empty();
    if (suggests) {
      label_class_->setEditText(classes.empty() ? QString()
                                                : QString::fromStdString(*classes.begin()));
      suggest();
    } else {
      instance_->setText(QString::fromStdString(labelInstance(label)));
    }
    check();
    label_class_->lineEdit()->selectAll();
    connect(label_class_, &QComboBox::editTextChanged, this, [this, suggests] {
      if (suggests) {
        suggest();
      }
      check();
    });
    connect(instance_, &QLineEdit::textChanged, this, [this] { check(); });
  }

  std::string label() const
  {
    return joinLabel(label_class_->currentText().trimmed().toStdString(),
                     instance_->text().trimmed().toStdString());
  }

 private:
  void suggest()
  {
    const std::string label_class = label_class_->currentText().trimmed().toStdString();
    instance_->setText(QString::fromStdString(nextInstance(label_class, labels_)));
  }

  void check()
  {
    const std::string name = label();
    std::string reason = whyNoLabel(name);
    if (labelClass(name).empty()) {
      reason = "a label needs a class, like tree";
    } else if (label_class_->currentText().contains('_')) {
      reason = "the name of a class has no underscore: what follows it is the instance";
    } else if (std::find(labels_.begin(), labels_.end(), name) != labels_.end()) {
      reason = "there is a label '" + name + "' already";
    }
    problem_->setText(QString::fromStdString(reason));
    buttons_->button(QDialogButtonBox::Ok)->setEnabled(reason.empty());
  }

  const std::vector<std::string> labels_;
  QComboBox* label_class_;
  QLineEdit* instance_;
  QLabel* problem_;
  QDialogButtonBox* buttons_;
};

}  // namespace

void askLabel(QWidget* parent, const QString& title, const std::string& label,
              const std::vector<std::string>& labels,
              const std::function<void(const std::string& label)>& done)
{
  auto* dialog = create<LabelDialog>(parent, title, label, labels);
  QObject::connect(dialog, &QDialog::accepted, parent, [dialog, done] { done(dialog->label()); });
  dialog->open();
}

void askChoice(QWidget* parent, const QString& title, const QString& question,
               const std::vector<std::string>& choices,
               const std::function<void(const std::string& choice)>& done)
{
  auto* dialog = create<QInputDialog>(parent, title);
  QStringList items;
  for (const std::string& choice : choices) {
    items.append(QString::fromStdString(choice));
  }
  dialog->setLabelText(question);
  dialog->setComboBoxItems(items);
  QObject::connect(dialog, &QInputDialog::textValueSelected, parent,
                   [done](const QString& choice) { done(choice.toStdString()); });
  dialog->open();
}

QWidget* askButton(QWidget* parent, const QString& title, const QString& question,
                   const std::vector<QString>& buttons, const std::function<void(int button)>& done,
                   const QString& nothing)
{
  auto* box = create<QMessageBox>(parent, title);
  box->setIcon(QMessageBox::Question);
  box->setText(question);
  QPushButton* first = nullptr;
  for (std::size_t i = 0; i < buttons.size(); ++i) {
    QPushButton* button = box->addButton(buttons[i], QMessageBox::ActionRole);
    QObject::connect(button, &QPushButton::clicked, parent,
                     [done, i] { done(static_cast<int>(i)); });
    first = first ? first : button;
  }
  QPushButton* cancel = box->addButton(nothing, QMessageBox::RejectRole);
  box->setDefaultButton(nothing == "Cancel" ? cancel : first);
  box->setEscapeButton(cancel);
  box->open();
  return box;
}

void askColor(QWidget* parent, const QString& title, const std::optional<Rgba8>& color,
              const std::function<void(const std::optional<Rgba8>& color)>& done)
{
  auto* dialog = create<QColorDialog>(parent, title);
  dialog->setOption(QColorDialog::DontUseNativeDialog);  // it gets one more button
  dialog->setCurrentColor(color ? toQColor(*color) : QColor(Qt::gray));
  if (auto* buttons = dialog->findChild<QDialogButtonBox*>()) {
    const auto* of_class = buttons->addButton("Color of Class", QDialogButtonBox::ResetRole);
    QObject::connect(of_class, &QPushButton::clicked, dialog, &QDialog::reject);
    QObject::connect(of_class, &QPushButton::clicked, parent, [done] { done(std::nullopt); });
  }
  QObject::connect(dialog, &QColorDialog::colorSelected, parent,
                   [done](const QColor& chosen) { done(toRgba8(chosen)); });
  dialog->open();
}

void askFile(QWidget* parent, bool write, const std::function<void(const std::string& path)>& done)
{
  auto* dialog = create<QFileDialog>(parent, write ? "Export Labels" : "Import Labels");
  if (write) {
    dialog->setNameFilters({"JSON (*.json)", "CSV (*.csv)"});
    dialog->setAcceptMode(QFileDialog::AcceptSave);
    dialog->setDefaultSuffix("json");
    // Others ask about the name as it is typed, without the suffix.
    dialog->setOption(QFileDialog::DontUseNativeDialog);
    QObject::connect(dialog, &QFileDialog::filterSelected, dialog, [dialog](const QString& filter) {
      dialog->setDefaultSuffix(filter.startsWith("CSV") ? "csv" : "json");
    });
  } else {
    dialog->setNameFilters({"Labels (*.json *.csv)", "All files (*)"});
    dialog->setFileMode(QFileDialog::ExistingFile);
  }
  QObject::connect(dialog, &QFileDialog::fileSelected, parent,
                   [done](const QString& path) { done(path.toStdString()); });
  dialog->open();
}

QString listed(const std::vector<std::string>& labels)
{
  QStringList names;
  for (std::size_t i = 0; i < std::min(labels.size(), MOST_LISTED); ++i) {
    names.append(QString::fromStdString(labels[i]));
  }
  const std::size_t more = labels.size() - static_cast<std::size_t>(names.size());
  return names.join(", ") + (more > 0 ? QString(" and %1 more").arg(more) : QString());
}

}  // namespace rviz_mesh_plugin
