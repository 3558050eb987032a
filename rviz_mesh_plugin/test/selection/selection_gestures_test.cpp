#include <gtest/gtest.h>
#include <rviz/viewport_mouse_event.h>
#include <QEvent>

#include "selection/selection_gestures.h"
#include "tools/selection/selection_keys.h"

using rviz_mesh_plugin::Gesture;
using rviz_mesh_plugin::Pixel;
using rviz_mesh_plugin::SelectionGestures;
using rviz_mesh_plugin::SelectionKey;
using rviz_mesh_plugin::selectionKey;
using rviz_mesh_plugin::SelectionTechnique;

namespace {

constexpr double AREA = 640 * 480;  // of which 30.72 pixels are a click

}  // namespace

class SelectionGesturesTest : public testing::Test
{
 protected:
  Gesture press(const Pixel& at, Qt::MouseButton button = Qt::LeftButton,
                Qt::KeyboardModifiers modifiers = Qt::NoModifier)
  {
    down |= button;
    return handle(QEvent::MouseButtonPress, at, button, modifiers);
  }
  Gesture move(const Pixel& at, Qt::KeyboardModifiers modifiers = Qt::NoModifier)
  {
    return handle(QEvent::MouseMove, at, Qt::NoButton, modifiers);
  }
  Gesture release(const Pixel& at, Qt::MouseButton button = Qt::LeftButton)
  {
    down &= ~Qt::MouseButtons(button);
    return handle(QEvent::MouseButtonRelease, at, button, Qt::NoModifier);
  }
  Gesture wheel(int delta, Qt::KeyboardModifiers modifiers = Qt::NoModifier)
  {
    return handle(QEvent::Wheel, {5, 5}, Qt::NoButton, modifiers, delta);
  }
  Gesture handle(QEvent::Type type, const Pixel& at, Qt::MouseButton button,
                 Qt::KeyboardModifiers modifiers, int wheel = 0)
  {
    rviz::ViewportMouseEvent event;
    event.type = type;
    event.x = at.x;
    event.y = at.y;
    event.acting_button = button;
    event.buttons_down = down;
    event.modifiers = modifiers;
    event.wheel_delta = wheel;
    return gestures.handle(event, technique, AREA);
  }

  SelectionGestures gestures;
  SelectionTechnique technique = SelectionTechnique::BOX;
  Qt::MouseButtons down = Qt::NoButton;
};

TEST_F(SelectionGesturesTest, a_drag_is_a_box_and_a_small_one_a_click)
{
  EXPECT_EQ(press({10, 20}).kind, Gesture::OUTLINE);
  EXPECT_EQ(move({50, 10}).kind, Gesture::OUTLINE);
  EXPECT_EQ(move({30, 40}).kind, Gesture::OUTLINE);
  EXPECT_EQ(gestures.path(), (std::vector<Pixel>{{10, 20}, {30, 40}}));
  const Gesture box = release({14, 28});
  EXPECT_EQ(box.kind, Gesture::BOX) << "32 pixels";
  EXPECT_EQ(box.from, (Pixel{10, 20}));
  EXPECT_EQ(box.to, (Pixel{14, 28}));
  EXPECT_TRUE(box.adding);
  press({10, 20}, Qt::RightButton);
  const Gesture click = release({40, 21}, Qt::RightButton);
  EXPECT_EQ(click.kind, Gesture::CLICK) << "30 pixels";
  EXPECT_EQ(click.to, (Pixel{40, 21}));
  EXPECT_FALSE(click.adding);
  EXPECT_EQ(release({1, 1}).kind, Gesture::NOTHING) << "of what was pressed elsewhere";
}

TEST_F(SelectionGesturesTest, a_lasso_keeps_its_way)
{
  technique = SelectionTechnique::LASSO;
  press({10, 20});
  move({10, 20});
  move({50, 20});
  move({50, 60});
  technique = SelectionTechnique::BOX;  // only for the next one
  EXPECT_EQ(release({10, 60}).kind, Gesture::LASSO);
  EXPECT_EQ(gestures.path(), (std::vector<Pixel>{{10, 20}, {50, 20}, {50, 60}, {10, 60}}));
  for (const auto points : {SelectionTechnique::FLOOD, SelectionTechnique::LABEL}) {
    technique = points;
    press({10, 20});
    move({300, 300});
    EXPECT_EQ(release({300, 300}).kind, Gesture::CLICK);
  }
}

TEST_F(SelectionGesturesTest, with_control_it_is_the_brush)
{
  EXPECT_FALSE(move({1, 1}).brush);
  EXPECT_TRUE(move({1, 1}, Qt::ControlModifier).brush);
  EXPECT_EQ(press({10, 20}, Qt::RightButton, Qt::ControlModifier).kind, Gesture::STROKE_BEGIN);
  const Gesture stroke = move({30, 20});  // also when Ctrl is released
  EXPECT_EQ(stroke.kind, Gesture::STROKE);
  EXPECT_EQ(stroke.from, (Pixel{10, 20}));
  EXPECT_FALSE(stroke.adding);
  EXPECT_EQ(wheel(-240, Qt::ControlModifier).kind, Gesture::RADIUS);
  EXPECT_EQ(wheel(-240, Qt::ControlModifier).notches, -2.0);
  EXPECT_EQ(wheel(-240).kind, Gesture::NOTHING) << "the camera stays where it is";
  const Gesture end = release({35, 20}, Qt::RightButton);
  EXPECT_EQ(end.kind, Gesture::STROKE_END);
  EXPECT_EQ(end.from, (Pixel{30, 20}));
  EXPECT_EQ(end.to, (Pixel{35, 20}));
}

TEST_F(SelectionGesturesTest, the_rest_is_the_cameras)
{
  EXPECT_EQ(wheel(120).kind, Gesture::CAMERA);
  press({1, 1}, Qt::MiddleButton);
  EXPECT_EQ(move({2, 2}).kind, Gesture::CAMERA);
  EXPECT_EQ(press({2, 2}, Qt::LeftButton).kind, Gesture::CAMERA);
  EXPECT_EQ(release({3, 3}, Qt::LeftButton).kind, Gesture::CAMERA);
  EXPECT_EQ(release({3, 3}, Qt::MiddleButton).kind, Gesture::CAMERA);
  EXPECT_EQ(move({2, 2}).kind, Gesture::HOVER);
  EXPECT_EQ(press({1, 1}, Qt::LeftButton, Qt::ShiftModifier | Qt::ControlModifier).kind,
            Gesture::CAMERA);
  EXPECT_EQ(release({3, 3}).kind, Gesture::CAMERA);
}

TEST_F(SelectionGesturesTest, a_drag_is_given_up)
{
  press({10, 20});
  move({50, 60});
  EXPECT_EQ(press({50, 60}, Qt::RightButton).kind, Gesture::GIVE_UP) << "a second button";
  EXPECT_EQ(move({70, 80}).kind, Gesture::NOTHING);
  EXPECT_EQ(release({70, 80}, Qt::RightButton).kind, Gesture::NOTHING);
  EXPECT_EQ(press({70, 80}, Qt::RightButton).kind, Gesture::NOTHING) << "left is still down";
  release({70, 80}, Qt::RightButton);
  EXPECT_EQ(release({70, 80}).kind, Gesture::NOTHING);
  press({10, 20}, Qt::LeftButton, Qt::ControlModifier);
  down = Qt::NoButton;
  EXPECT_EQ(move({70, 80}).kind, Gesture::GIVE_UP) << "the button was released elsewhere";
  EXPECT_EQ(press({10, 20}).kind, Gesture::OUTLINE);
  EXPECT_TRUE(gestures.giveUp());
  EXPECT_FALSE(gestures.giveUp());
  EXPECT_EQ(release({70, 80}).kind, Gesture::NOTHING);
  EXPECT_EQ(press({10, 20}).kind, Gesture::OUTLINE);
}

TEST(SelectionKeysTest, what_keys_mean)
{
  const auto control = Qt::ControlModifier;
  const auto both = Qt::ControlModifier | Qt::ShiftModifier;
  EXPECT_EQ(selectionKey(Qt::Key_Z, control), SelectionKey::UNDO);
  EXPECT_EQ(selectionKey(Qt::Key_Z, both), SelectionKey::REDO);
  EXPECT_EQ(selectionKey(Qt::Key_Y, control), SelectionKey::REDO);
  EXPECT_EQ(selectionKey(Qt::Key_A, control), SelectionKey::ALL);
  EXPECT_EQ(selectionKey(Qt::Key_A, both), SelectionKey::CLEAR);
  EXPECT_EQ(selectionKey(Qt::Key_Delete, Qt::NoModifier), SelectionKey::CLEAR);
  EXPECT_EQ(selectionKey(Qt::Key_I, control), SelectionKey::INVERT);
  EXPECT_EQ(selectionKey(Qt::Key_Plus, Qt::ShiftModifier), SelectionKey::GROW);
  EXPECT_EQ(selectionKey(Qt::Key_Plus, Qt::KeypadModifier), SelectionKey::GROW);
  EXPECT_EQ(selectionKey(Qt::Key_Minus, Qt::NoModifier), SelectionKey::SHRINK);
  EXPECT_EQ(selectionKey(Qt::Key_2, Qt::NoModifier), SelectionKey::LASSO);
  EXPECT_EQ(selectionKey(Qt::Key_Enter, Qt::KeypadModifier), SelectionKey::REQUEST_LABEL);
  EXPECT_EQ(selectionKey(Qt::Key_Escape, Qt::NoModifier), SelectionKey::GIVE_UP);
  for (const int key : {Qt::Key_A, Qt::Key_I, Qt::Key_T, Qt::Key_B, Qt::Key_Y, Qt::Key_Z}) {
    EXPECT_EQ(selectionKey(key, Qt::NoModifier), SelectionKey::NONE)
        << "other tools' or the view's";
    EXPECT_EQ(selectionKey(key, control | Qt::AltModifier), SelectionKey::NONE);
  }
}
