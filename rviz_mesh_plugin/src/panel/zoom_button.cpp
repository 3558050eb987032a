#include "panel/zoom_button.h"

#include <algorithm>
#include <utility>

#include <QMenu>
#include <QTimer>

#include <rviz/display_context.h>
#include <rviz/view_manager.h>

#include "base/vectors.h"
#include "picking/surface_picker.h"
#include "picking/view_zoom.h"

namespace rviz_mesh_plugin {
namespace {

constexpr int LOOK_EVERY = 30;  // ms

/// So many faces are looked at between two looks at the cancel flag.
constexpr std::uint32_t ZOOM_STRETCH = 1 << 16;

/// Of what is not hidden. @param whole all of the mesh, else the labels or faces of the target
Bounds boundsOf(const MeshData& mesh, const ZoomTarget& target, bool whole,
                const Cancellation& cancellation)
{
  if (whole && !target.hidden) {
    return mesh;
  }
  Bounds bounds = Bounds::none();
  const auto add = [&](std::uint32_t face) {
    if (face % ZOOM_STRETCH == 0) {
      throwIfCanceled(&cancellation.flag());
    }
    for (unsigned corner = 0; corner < 3 && !(target.hidden && target.hidden->contains(face));
         ++corner) {
      bounds.enclose(cornerOf(mesh, face, corner));
    }
  };
  for (std::uint32_t face = 0; whole && face < mesh.faceCount(); ++face) {
    add(face);
  }
  for (const LabelClusterConstPtr& label : target.labels) {
    for (const std::uint32_t face : label->faces) {
      if (face < mesh.faceCount()) {
        add(face);
      }
    }
  }
  if (target.faces) {
    target.faces->visit(add);
  }
  return bounds;
}

}  // namespace

ZoomButton::ZoomButton(std::function<ZoomTarget()> target,
                       std::function<rviz::DisplayContext*()> context)
    : QPushButton("Zoom To"), target_(std::move(target)), context_(std::move(context))
{
  auto* menu = new QMenu(this);
  connect(menu->addAction("&Mesh"), &QAction::triggered, this, [this] { zoom(MESH); });
  connect(menu->addAction("&Labels in the List"), &QAction::triggered, this,
          [this] { zoom(LABELS); });
  connect(menu->addAction("&Selection"), &QAction::triggered, this, [this] { zoom(SELECTION); });
  setMenu(menu);
  allow(false);
  timer_ = new QTimer(this);
  timer_->setInterval(LOOK_EVERY);
  connect(timer_, &QTimer::timeout, this, &ZoomButton::finish);
}

void ZoomButton::allow(bool has_mesh)
{
  const QString tip =
      "Moves the camera so that all of the mesh, the labels or the selection is seen";
  setEnabled(has_mesh);
  setToolTip(has_mesh ? tip + "." : tip + ".\nNot now: there is no mesh, add a display of one.");
}

void ZoomButton::say(const QString& text)
{
  if (rviz::DisplayContext* context = context_()) {
    context->setStatus(text);
  }
}

void ZoomButton::zoom(What what)
{
  ZoomTarget target = target_();
  if (!target.mesh) {
    say("There is no mesh to zoom to: add a display of one");
    return;
  }
  if (what == LABELS && target.labels.empty()) {
    say("No label is chosen in the list: choose one to zoom to it");
    return;
  }
  if (what == SELECTION && (!target.faces || target.faces->count() == 0)) {
    say("No face of this mesh is selected: select some to zoom to them");
    return;
  }
  if (what != LABELS) {
    target.labels.clear();
  }
  if (what != SELECTION) {
    target.faces.reset();
  }
  mesh_ = target.mesh;
  target.hidden = hiddenFaces(*target.mesh);
  try {
    task_.start([what, target = std::move(target)](const Cancellation& cancellation) {
      return boundsOf(*target.mesh, target, what == MESH, cancellation);
    });
    timer_->start();
  } catch (const std::exception& error) {  // no thread
    say(QString("Zooming failed: ") + error.what());
  }
}

void ZoomButton::finish()
{
  const auto outcome = task_.take();
  if (!outcome) {
    return;
  }
  timer_->stop();
  rviz::DisplayContext* const context = context_();
  rviz::ViewManager* const views = context ? context->getViewManager() : nullptr;
  if (!views || !views->getCurrent()) {
    return;
  }
  if (!outcome->result) {
    say(QString("Zooming failed: ") + outcome->error.c_str());
    return;
  }
  if (outcome->result->lower[0] > outcome->result->upper[0]) {
    say("None of it is shown: there is nothing to zoom to");
    return;
  }
  const MeshDataConstPtr mesh = mesh_.lock();
  for (const ShownMesh& shown : SurfacePicker(context).meshes()) {
    if (shown.mesh == mesh) {
      Bounds seen = *outcome->result;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        seen.lower[axis] = std::max(seen.lower[axis], shown.section.lower[axis]);
        seen.upper[axis] = std::min(seen.upper[axis], shown.section.upper[axis]);
      }
      if (!shown.section.touches(*outcome->result)) {
        say("Nothing of it is in the section of its display: there is nothing to zoom to");
        return;
      }
      if (!zoomTo(*views->getCurrent(), boxInFixedFrame(seen, shown))) {
        say("This view does not show it: it lies behind its camera (TopDownOrtho sees nothing "
            "above "
            "500 m). Choose another view, as Orbit");
      }
      context->queueRender();
      return;
    }
  }
  say("The mesh is not shown: enable its display to zoom to it");
}

}  // namespace rviz_mesh_plugin
