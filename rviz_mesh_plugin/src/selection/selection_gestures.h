#pragma once

#include <utility>
#include <vector>

#include <qnamespace.h>

namespace rviz {
class ViewportMouseEvent;
}

namespace rviz_mesh_plugin {

/// What a click or drag selects with.
enum class SelectionTechnique
{
  BOX,
  LASSO,
  FLOOD,  ///< the connected region around a face
  LABEL   ///< the faces of the label on a face
};

struct Pixel
{
  int x = 0;
  int y = 0;
};

inline bool operator==(const Pixel& a, const Pixel& b)
{
  return a.x == b.x && a.y == b.y;
}

/// The lower and the upper corner of a path, which is not empty.
std::pair<Pixel, Pixel> boundsOf(const std::vector<Pixel>& path);

/// What is to be done.
struct Gesture
{
  enum Kind
  {
    NOTHING,
    CAMERA,   ///< the view controller's
    HOVER,    ///< `brush`: over the surface with the brush
    OUTLINE,  ///< path() is being dragged
    CLICK,
    BOX,
    LASSO,
    STROKE_BEGIN,
    STROKE,
    STROKE_END,
    RADIUS,  ///< of the brush, by `notches`
    GIVE_UP  ///< what was being dragged
  };
  Kind kind = NOTHING;
  bool adding = true;  ///< false: taking away
  bool brush = false;
  Pixel from;  ///< corner of the box; last place of the brush
  Pixel to;    ///< where the mouse is
  double notches = 0.0;
};

/// Tells what is meant by the buttons and moves of the mouse. Left selects and right deselects;
/// with Ctrl it is the brush. The middle button, the wheel and whatever begins with Shift is the
/// camera's. A second button gives up what is being dragged, and so does a move without the button
/// (its release went elsewhere).
class SelectionGestures
{
 public:
  /// Of a smaller share of the picture, a drag is a click.
  static constexpr double CLICK_SHARE = 1e-4;

  /// @param picture_area in pixels
  Gesture handle(const rviz::ViewportMouseEvent& event, SelectionTechnique technique,
                 double picture_area);

  /// Forgets what is being dragged; returns whether anything but the camera was.
  bool giveUp();

  bool isDragging() const { return state_ == State::DRAG || state_ == State::STROKE; }
  bool isAdding() const { return button_ == Qt::LeftButton; }
  SelectionTechnique technique() const { return technique_; }

  /// Where the drag has been: the corners of the lasso, or from one corner of the box to the other.
  const std::vector<Pixel>& path() const { return path_; }

 private:
  enum class State
  {
    IDLE,
    CAMERA,
    DRAG,
    STROKE,
    IGNORED  ///< given up; the buttons are still down
  };

  Gesture press(const rviz::ViewportMouseEvent& event, SelectionTechnique technique);
  Gesture move(const rviz::ViewportMouseEvent& event);
  Gesture release(const rviz::ViewportMouseEvent& event, double picture_area);
  Gesture wheel(const rviz::ViewportMouseEvent& event) const;
  Gesture make(Gesture::Kind kind, const rviz::ViewportMouseEvent& event) const;
  Gesture follow(Gesture::Kind kind, const rviz::ViewportMouseEvent& event);
  bool isClick(double picture_area) const;

  State state_ = State::IDLE;
  Qt::MouseButton button_ = Qt::NoButton;
  SelectionTechnique technique_ = SelectionTechnique::BOX;
  std::vector<Pixel> path_;
};

}  // namespace rviz_mesh_plugin
