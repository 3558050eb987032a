#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <QString>

#include "base/mesh_data.h"

class QWidget;

namespace rviz_mesh_plugin {

/// Dialogs of the panel of labels: they open, return at once, and call back where the user has
/// decided. They are gone with their parent. What is called back must not throw.

/// Asks for class and instance, and suggests them.
/// @param label to begin with; empty: none
/// @param labels that there are: the name has to be another one
void askLabel(QWidget* parent, const QString& title, const std::string& label,
              const std::vector<std::string>& labels,
              const std::function<void(const std::string& label)>& done);

/// Asks which of these.
void askChoice(QWidget* parent, const QString& title, const QString& question,
               const std::vector<std::string>& choices,
               const std::function<void(const std::string& choice)>& done);

/// Asks to press one of these buttons, or the one that does nothing, as the key Escape does. That
/// is what the key Enter does, too, where it is called Cancel; else it presses the first one.
QWidget* askButton(QWidget* parent, const QString& title, const QString& question,
                   const std::vector<QString>& buttons, const std::function<void(int button)>& done,
                   const QString& nothing = "Cancel");

/// Asks for a color; none: that of the class.
/// @param color to begin with
void askColor(QWidget* parent, const QString& title, const std::optional<Rgba8>& color,
              const std::function<void(const std::optional<Rgba8>& color)>& done);

/// Asks for a file of labels to be read or written.
void askFile(QWidget* parent, bool write, const std::function<void(const std::string& path)>& done);

/// "a, b and 3 more".
QString listed(const std::vector<std::string>& labels);

}  // namespace rviz_mesh_plugin
