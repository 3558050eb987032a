#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace rviz_mesh_plugin {

/// In which place of an index buffer each face of a label is: faces that stay keep their places, so
/// that only what has changed needs to be uploaded. Many faces are given places in slices.
class IndexSlots
{
 public:
  using Faces = std::vector<std::uint32_t>;

  /// Places from begin to before end.
  struct Range
  {
    std::size_t begin = 0;
    std::size_t end = 0;
  };

  /// Begins to give places to these faces (ascending, each once) and no others; to be called once
  /// those before have theirs.
  void assign(std::shared_ptr<const Faces> faces);

  /// Gives places to these faces, and takes those of the others away, at once: takes as long as
  /// there are faces in both (ascending). To be called while isSettled(). Faces that have places
  /// are not given others, and those that have none have none to take.
  void change(const Faces& added, const Faces& removed);

  /// Looks at about so many faces; returns at how many, 0 where all have their places.
  std::size_t work(std::size_t limit);
  bool isSettled() const { return step_ == Step::NONE; }

  /// By place. Before all have theirs, there are faces of before among them.
  const Faces& faces() const { return faces_; }

  /// The places that have another face than when they were taken before, ascending; near ones are
  /// joined, with few unchanged places between them. To be taken before the next assign().
  std::vector<Range> takeChanged();

 private:
  enum class Step
  {
    NONE,
    MARK,    ///< the faces that are wanted
    SEARCH,  ///< for places whose faces are not
    FILL,    ///< these places, then more
    CLOSE    ///< what is left of them, from the end
  };

  std::size_t length() const;
  void look(std::size_t begin, std::size_t end);
  void fill(std::uint32_t face);
  void closeHole();
  void put(std::size_t place, std::uint32_t face);
  void makeRoom(const Faces& faces);

  Faces faces_;
  std::vector<Range> changed_;
  Step step_ = Step::NONE;
  std::size_t next_ = 0;  ///< of the step
  std::shared_ptr<const Faces> wanted_;
  std::vector<bool> missing_;          ///< faces that are wanted and have no place
  std::vector<std::uint32_t> holes_;   ///< places whose faces are not wanted, ascending
  std::size_t filled_ = 0;             ///< of the holes
  std::vector<std::uint32_t> places_;  ///< by face, once there was a change(); else empty
};

}  // namespace rviz_mesh_plugin
