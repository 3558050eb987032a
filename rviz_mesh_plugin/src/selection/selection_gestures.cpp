#include "selection/selection_gestures.h"

#include <algorithm>

#include <rviz/viewport_mouse_event.h>
#include <QEvent>

namespace rviz_mesh_plugin {
namespace {

Pixel pixelOf(const rviz::ViewportMouseEvent& event)
{
  return {event.x, event.y};
}

}  // namespace

std::pair<Pixel, Pixel> boundsOf(const std::vector<Pixel>& path)
{
  Pixel lower = path.front(), upper = lower;
  for (const Pixel& pixel : path) {
    lower = {std::min(lower.x, pixel.x), std::min(lower.y, pixel.y)};
    upper = {std::max(upper.x, pixel.x), std::max(upper.y, pixel.y)};
  }
  return {lower, upper};
}

Gesture SelectionGestures::handle(const rviz::ViewportMouseEvent& event,
                                  SelectionTechnique technique, double picture_area)
{
  switch (event.type) {
    case QEvent::MouseButtonPress:
      return press(event, technique);
    case QEvent::MouseButtonRelease:
      return release(event, picture_area);
    case QEvent::Wheel:
      return wheel(event);
    default:
      return move(event);
  }
}

bool SelectionGestures::giveUp()
{
  const bool dragging = isDragging();
  path_.clear();
  state_ = dragging ? State::IGNORED : State::IDLE;
  return dragging;
}

Gesture SelectionGestures::press(const rviz::ViewportMouseEvent& event,
                                 SelectionTechnique technique)
{
  if (isDragging()) {
    giveUp();
    return make(Gesture::GIVE_UP, event);
  }
  if (state_ == State::CAMERA) {
    return make(Gesture::CAMERA, event);
  }
  if (state_ == State::IGNORED && event.buttons_down != Qt::MouseButtons(event.acting_button)) {
    return {};
  }
  button_ = event.acting_button;
  technique_ = technique;
  path_ = {pixelOf(event)};
  const bool selects = button_ == Qt::LeftButton || button_ == Qt::RightButton;
  if (!selects || (event.modifiers & Qt::ShiftModifier) != 0) {
    state_ = State::CAMERA;
    return make(Gesture::CAMERA, event);
  }
  if ((event.modifiers & Qt::ControlModifier) != 0) {
    state_ = State::STROKE;
    return make(Gesture::STROKE_BEGIN, event);
  }
  state_ = State::DRAG;
  return make(Gesture::OUTLINE, event);
}

Gesture SelectionGestures::move(const rviz::ViewportMouseEvent& event)
{
  if (isDragging() && (event.buttons_down & button_) == 0) {
    giveUp();
    state_ = State::IDLE;
    return make(Gesture::GIVE_UP, event);
  }
  if (event.buttons_down == Qt::NoButton) {
    state_ = State::IDLE;
  }
  switch (state_) {
    case State::CAMERA:
      return make(Gesture::CAMERA, event);
    case State::STROKE:
      return follow(Gesture::STROKE, event);
    case State::DRAG:
      return follow(Gesture::OUTLINE, event);
    case State::IGNORED:
      return {};
    default:
      break;
  }
  Gesture gesture = make(Gesture::HOVER, event);
  gesture.brush = event.buttons_down == Qt::NoButton &&
                  (event.modifiers & Qt::ControlModifier) != 0 &&
                  (event.modifiers & Qt::ShiftModifier) == 0;
  return gesture;
}

Gesture SelectionGestures::release(const rviz::ViewportMouseEvent& event, double picture_area)
{
  const State state = state_;
  if (state == State::CAMERA || state == State::IGNORED) {
    state_ = event.buttons_down == Qt::NoButton ? State::IDLE : state;
    return state == State::CAMERA ? make(Gesture::CAMERA, event) : Gesture();
  }
  if (!isDragging() || event.acting_button != button_) {
    return {};
  }
  Gesture gesture = follow(Gesture::STROKE_END, event);
  state_ = State::IDLE;
  if (state == State::STROKE) {
    return gesture;
  }
  const bool area =
      technique_ == SelectionTechnique::BOX || technique_ == SelectionTechnique::LASSO;
  gesture.from = path_.front();
  if (!area || isClick(picture_area)) {
    gesture.kind = Gesture::CLICK;
  } else {
    gesture.kind = technique_ == SelectionTechnique::BOX ? Gesture::BOX : Gesture::LASSO;
  }
  return gesture;
}

Gesture SelectionGestures::wheel(const rviz::ViewportMouseEvent& event) const
{
  const bool brush = (event.modifiers & Qt::ControlModifier) != 0;
  if (state_ == State::DRAG || state_ == State::IGNORED || (state_ == State::STROKE && !brush)) {
    return {};
  }
  Gesture gesture = make(brush ? Gesture::RADIUS : Gesture::CAMERA, event);
  gesture.notches = event.wheel_delta / 120.0;
  return gesture;
}

Gesture SelectionGestures::make(Gesture::Kind kind, const rviz::ViewportMouseEvent& event) const
{
  Gesture gesture;
  gesture.kind = kind;
  gesture.adding = isAdding();
  gesture.from = gesture.to = pixelOf(event);
  return gesture;
}

/// The path goes on to where the mouse is.
Gesture SelectionGestures::follow(Gesture::Kind kind, const rviz::ViewportMouseEvent& event)
{
  Gesture gesture = make(kind, event);
  gesture.from = path_.back();
  if (state_ != State::DRAG || technique_ != SelectionTechnique::LASSO) {
    path_.resize(1);  // only both ends matter
    if (state_ == State::STROKE) {
      path_.clear();
    }
    path_.push_back(pixelOf(event));
  } else if (!(path_.back() == pixelOf(event))) {
    path_.push_back(pixelOf(event));
  }
  return gesture;
}

bool SelectionGestures::isClick(double picture_area) const
{
  const auto [lower, upper] = boundsOf(path_);
  const double area = static_cast<double>(upper.x - lower.x) * (upper.y - lower.y);
  return area < CLICK_SHARE * picture_area;
}

}  // namespace rviz_mesh_plugin
