#include "tools/selection/selection_keys.h"

namespace rviz_mesh_plugin {
namespace {

struct Binding
{
  int key;
  SelectionKey meaning;
};

constexpr Binding PLAIN[] = {
    {Qt::Key_Delete, SelectionKey::CLEAR},
    {Qt::Key_Plus, SelectionKey::GROW},
    {Qt::Key_Equal, SelectionKey::GROW},  // the same key without Shift, on many keyboards
    {Qt::Key_Minus, SelectionKey::SHRINK},
    {Qt::Key_1, SelectionKey::BOX},
    {Qt::Key_2, SelectionKey::LASSO},
    {Qt::Key_3, SelectionKey::FLOOD},
    {Qt::Key_4, SelectionKey::LABEL},
    {Qt::Key_Return, SelectionKey::REQUEST_LABEL},
    {Qt::Key_Enter, SelectionKey::REQUEST_LABEL},
    {Qt::Key_Escape, SelectionKey::GIVE_UP},
};

constexpr Binding CONTROL[] = {
    {Qt::Key_Z, SelectionKey::UNDO},
    {Qt::Key_Y, SelectionKey::REDO},
    {Qt::Key_A, SelectionKey::ALL},
    {Qt::Key_I, SelectionKey::INVERT},
    {Qt::Key_T, SelectionKey::TOGGLE_VISIBLE_ONLY},
    {Qt::Key_B, SelectionKey::TOGGLE_BACK_FACES},
};

constexpr Binding CONTROL_SHIFT[] = {
    {Qt::Key_Z, SelectionKey::REDO},
    {Qt::Key_A, SelectionKey::CLEAR},
};

template <class Bindings>
SelectionKey find(const Bindings& bindings, int key)
{
  for (const Binding& binding : bindings) {
    if (binding.key == key) {
      return binding.meaning;
    }
  }
  return SelectionKey::NONE;
}

}  // namespace

SelectionKey selectionKey(int key, Qt::KeyboardModifiers modifiers)
{
  if ((modifiers & (Qt::AltModifier | Qt::MetaModifier)) != 0) {
    return SelectionKey::NONE;
  }
  if ((modifiers & Qt::ControlModifier) == 0) {
    return find(PLAIN, key);
  }
  return (modifiers & Qt::ShiftModifier) != 0 ? find(CONTROL_SHIFT, key) : find(CONTROL, key);
}

}  // namespace rviz_mesh_plugin
