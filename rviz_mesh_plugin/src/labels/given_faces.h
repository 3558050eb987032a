#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <utility>
#include <vector>

#include "base/face_bits.h"
#include "labels/label_faces.h"

namespace rviz_mesh_plugin {

/// Faces in any order, from whoever edits labels: few are given as they are, and of many it is not
/// the GUI thread that makes a list.
class GivenFaces
{
 public:
  using Faces = std::vector<std::uint32_t>;

  GivenFaces(std::initializer_list<std::uint32_t> faces) : GivenFaces(Faces(faces)) {}
  GivenFaces(Faces faces) : list_(labelFaces(std::move(faces))), count_(list_->size()) {}
  GivenFaces(LabelFacesConstPtr faces) : list_(std::move(faces)), count_(list_->size()) {}
  GivenFaces(FaceBits faces)
      : bits_(std::make_shared<const FaceBits>(std::move(faces))), count_(bits_->count())
  {
  }

  std::size_t count() const { return count_; }
  /// Ascending, each once; for any thread. Takes long for many. @throw std::bad_alloc
  LabelFacesConstPtr sorted() const;

 private:
  LabelFacesConstPtr list_;  ///< null: bits
  std::shared_ptr<const FaceBits> bits_;
  std::size_t count_;
};

}  // namespace rviz_mesh_plugin
