#include "selection/selection_gestures.h"

#include <algorithm>
#include <cstdlib>

namespace rviz_mesh_plugin {

constexpr double SelectionGestures::CLICK_SHARE;

Gesture SelectionGestures::handle(const MouseInput& input, SelectionTechnique technique,
                                  double picture_area)
{
  switch (input.type) {
    case MouseInput::PRESS:
      return press(input, technique);
    case MouseInput::RELEASE:
      return release(input, picture_area);
    case MouseInput::WHEEL:
      return wheel(input);
    default:
      return move(input);
  }
}

bool SelectionGestures::giveUp()
{
  const bool dragging = isDragging();
  path_.clear();
  state_ = dragging ? State::IGNORED : State::IDLE;
  return dragging;
}

Gesture SelectionGestures::press(const MouseInput& input, SelectionTechnique technique)
{
  if (isDragging()) {
    giveUp();
    return make(Gesture::GIVE_UP, input);
  }
  if (state_ == State::CAMERA) {
    return make(Gesture::CAMERA, input);
  }
  if (state_ == State::IGNORED && input.down != Qt::MouseButtons(input.button)) {
    return {};
  }
  button_ = input.button;
  technique_ = technique;
  path_ = {input.at};
  const bool selects = button_ == Qt::LeftButton || button_ == Qt::RightButton;
  if (!selects || (input.modifiers & Qt::ShiftModifier) != 0) {
    state_ = State::CAMERA;
    return make(Gesture::CAMERA, input);
  }
  if ((input.modifiers & Qt::ControlModifier) != 0) {
    state_ = State::STROKE;
    return make(Gesture::STROKE_BEGIN, input);
  }
  state_ = State::DRAG;
  return make(Gesture::OUTLINE, input);
}

Gesture SelectionGestures::move(const MouseInput& input)
{
  if (isDragging() && (input.down & button_) == 0) {
    giveUp();
    state_ = State::IDLE;
    return make(Gesture::GIVE_UP, input);
  }
  if (input.down == Qt::NoButton) {
    state_ = State::IDLE;
  }
  switch (state_) {
    case State::CAMERA:
      return make(Gesture::CAMERA, input);
    case State::STROKE:
      return follow(Gesture::STROKE, input);
    case State::DRAG:
      return follow(Gesture::OUTLINE, input);
    case State::IGNORED:
      return {};
    default:
      break;
  }
  Gesture gesture = make(Gesture::HOVER, input);
  gesture.brush = input.down == Qt::NoButton && (input.modifiers & Qt::ControlModifier) != 0 &&
                  (input.modifiers & Qt::ShiftModifier) == 0;
  return gesture;
}

Gesture SelectionGestures::release(const MouseInput& input, double picture_area)
{
  const State state = state_;
  if (state == State::CAMERA || state == State::IGNORED) {
    state_ = input.down == Qt::NoButton ? State::IDLE : state;
    return state == State::CAMERA ? make(Gesture::CAMERA, input) : Gesture();
  }
  if (!isDragging() || input.button != button_) {
    return {};
  }
  Gesture gesture = follow(Gesture::STROKE_END, input);
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

Gesture SelectionGestures::wheel(const MouseInput& input) const
{
  const bool brush = (input.modifiers & Qt::ControlModifier) != 0;
  if (state_ == State::DRAG || state_ == State::IGNORED || (state_ == State::STROKE && !brush)) {
    return {};
  }
  Gesture gesture = make(brush ? Gesture::RADIUS : Gesture::CAMERA, input);
  gesture.notches = input.wheel / 120.0;
  return gesture;
}

Gesture SelectionGestures::make(Gesture::Kind kind, const MouseInput& input) const
{
  Gesture gesture;
  gesture.kind = kind;
  gesture.adding = isAdding();
  gesture.from = gesture.to = input.at;
  return gesture;
}

/// The path goes on to where the mouse is.
Gesture SelectionGestures::follow(Gesture::Kind kind, const MouseInput& input)
{
  Gesture gesture = make(kind, input);
  gesture.from = path_.back();
  if (state_ != State::DRAG || technique_ != SelectionTechnique::LASSO) {
    path_.resize(1);  // only both ends matter
    if (state_ == State::STROKE) {
      path_.clear();
    }
    path_.push_back(input.at);
  } else if (!(path_.back() == input.at)) {
    path_.push_back(input.at);
  }
  return gesture;
}

bool SelectionGestures::isClick(double picture_area) const
{
  Pixel lower = path_.front(), upper = lower;
  for (const Pixel& pixel : path_) {
    lower = {std::min(lower.x, pixel.x), std::min(lower.y, pixel.y)};
    upper = {std::max(upper.x, pixel.x), std::max(upper.y, pixel.y)};
  }
  const double area = static_cast<double>(upper.x - lower.x) * (upper.y - lower.y);
  return area < CLICK_SHARE * picture_area;
}

}  // namespace rviz_mesh_plugin
