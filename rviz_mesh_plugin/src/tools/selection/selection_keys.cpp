#include "tools/selection/selection_keys.h"

namespace rviz_mesh_plugin {
namespace {

constexpr int PLAIN = Qt::NoModifier;  // with Shift or without, unless that means something
constexpr int SHIFT = Qt::ShiftModifier;
constexpr int CONTROL = Qt::ControlModifier;
constexpr int CONTROL_SHIFT = Qt::ControlModifier | Qt::ShiftModifier;

struct Binding
{
  int modifiers;
  int key;
  SelectionKey meaning;
};

constexpr Binding BINDINGS[] = {
    {PLAIN, Qt::Key_Delete, SelectionKey::CLEAR},
    {PLAIN, Qt::Key_Plus, SelectionKey::GROW},
    {PLAIN, Qt::Key_Equal, SelectionKey::GROW},  // the same key without Shift, on many keyboards
    {PLAIN, Qt::Key_Minus, SelectionKey::SHRINK},
    {PLAIN, Qt::Key_1, SelectionKey::BOX},
    {PLAIN, Qt::Key_2, SelectionKey::LASSO},
    {PLAIN, Qt::Key_3, SelectionKey::FLOOD},
    {PLAIN, Qt::Key_4, SelectionKey::LABEL},
    {PLAIN, Qt::Key_H, SelectionKey::HIDE},
    {SHIFT, Qt::Key_H, SelectionKey::ISOLATE},
    {PLAIN, Qt::Key_Return, SelectionKey::REQUEST_LABEL},
    {PLAIN, Qt::Key_Enter, SelectionKey::REQUEST_LABEL},
    {PLAIN, Qt::Key_Escape, SelectionKey::GIVE_UP},
    {CONTROL, Qt::Key_Z, SelectionKey::UNDO},
    {CONTROL, Qt::Key_Y, SelectionKey::REDO},
    {CONTROL, Qt::Key_A, SelectionKey::ALL},
    {CONTROL, Qt::Key_I, SelectionKey::INVERT},
    {CONTROL, Qt::Key_H, SelectionKey::SHOW_ALL},
    {CONTROL, Qt::Key_T, SelectionKey::TOGGLE_VISIBLE_ONLY},
    {CONTROL, Qt::Key_B, SelectionKey::TOGGLE_BACK_FACES},
    {CONTROL_SHIFT, Qt::Key_Z, SelectionKey::REDO},
    {CONTROL_SHIFT, Qt::Key_A, SelectionKey::CLEAR},
};

}  // namespace

SelectionKey selectionKey(int key, Qt::KeyboardModifiers modifiers)
{
  constexpr int ANY = Qt::ControlModifier | Qt::ShiftModifier | Qt::AltModifier | Qt::MetaModifier;
  const int held = static_cast<int>(modifiers) & ANY;  // not that the key is of a keypad
  for (const int wanted : {held, held == SHIFT ? PLAIN : held}) {
    for (const Binding& binding : BINDINGS) {
      if (binding.modifiers == wanted && binding.key == key) {
        return binding.meaning;
      }
    }
  }
  return SelectionKey::NONE;
}

}  // namespace rviz_mesh_plugin
