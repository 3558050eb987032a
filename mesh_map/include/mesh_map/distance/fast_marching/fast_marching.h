#pragma once

#include <mesh_map/distance/fast_marching/fast_marching_mesh.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <mutex>
#include <vector>

namespace mesh_map {

struct FastMarchingBuffers;

/// Where a front starts: a vertex, and its potential there, finite and >= 0.
struct FastMarchingSeed
{
  std::uint32_t vertex;
  double label;
};

/// How far a front is wanted. Views have to outlive the call.
struct FastMarchingStop
{
  /// It ends `offset` beyond the farthest of these, once all are final. None: the whole field; so
  /// do targets that cannot be reached.
  ArrayView<std::uint32_t> targets;
  double offset = 0.0;  ///< finite, >= 0
  double max_distance = std::numeric_limits<double>::infinity();
  const std::atomic<bool>* cancel = nullptr;
};

/// The mesh of many fronts, and buffers that are used again, so that a front costs what it touches,
/// not what the mesh has. Any number of threads may take fields from it.
class FastMarchingPool
{
 public:
  explicit FastMarchingPool(std::shared_ptr<const FastMarchingMesh> mesh);
  ~FastMarchingPool();

  const FastMarchingMesh& mesh() const { return *mesh_; }

  /// Labels that are all infinite, and an empty queue.
  std::unique_ptr<FastMarchingBuffers> take();
  void giveBack(std::unique_ptr<FastMarchingBuffers> buffers);

 private:
  std::shared_ptr<const FastMarchingMesh> mesh_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<FastMarchingBuffers>> spare_;
};

/// Fast marching over the surface of any triangle soup: a front from a point, across faces, that
/// may stop, go on, and be mended after changes of costs. Its potential T solves the eikonal
/// equation |grad T| = slowness.
///
/// From the labels of two corners of a triangle follows where the source lies when all that is
/// between is unfolded into its plane; what is beyond their side gets its distance from there, if
/// the straight line crosses that side, and if the front can have come to that side through another
/// face. A label may be lowered at any time, and then all around it is looked at again. So no order
/// is needed, obtuse triangles are no special case, and on planes the result is exact on any
/// triangulation. What follows is monotone in the labels, and is looked at again when any label
/// that it follows from is lowered; so the result does not depend on the order, but for a relative
/// 1e-7, below which a label is left as it is.
///
/// On bent surfaces the front between two labels is no circle. So a label is also derived from one
/// face further back, and the lower one counts, which halves the error.
///
/// Costs: `slowness` is the time that a meter takes, per vertex, linear in between; empty for 1
/// everywhere. Vertices with +inf or NaN are closed: never reached, not even as a seed, and faces
/// with a closed corner are not crossed. Where slowness varies by more than 30 % within the faces
/// on both sides of an edge, the front through it is taken as straight, not as round; so it is over
/// edges to which the third corner is near by less than a tenth of them, where slowness varies.
///
/// The values of slowness have to be the same, and to live, during all calls, but for what update()
/// is told. One call at a time.
class FastMarchingField
{
 public:
  /// Throws std::invalid_argument for a seed that does not exist or is out of its range, a wrong
  /// number of values of slowness, or a negative one.
  FastMarchingField(std::shared_ptr<FastMarchingPool> pool, std::vector<FastMarchingSeed> seeds,
                    ArrayView<float> slowness);
  ~FastMarchingField();
  FastMarchingField(const FastMarchingField&) = delete;
  FastMarchingField& operator=(const FastMarchingField&) = delete;

  /// Goes on where it stopped; does nothing where enough is final. False if it was canceled: the
  /// field is then as good as before, and may go on. Throws std::invalid_argument for a target that
  /// does not exist, or a number out of its range.
  bool extend(ArrayView<float> slowness, const FastMarchingStop& stop);

  struct Update
  {
    std::size_t count = 0;  ///< labels that are other than before; of a new field all
    std::size_t looks = 0;  ///< how often a label was looked at to repair it
    bool canceled = false;  ///< then nothing is final until extend() or update() have ended
  };

  /// After the slowness of the vertices `changed` has changed: labels become what they are in a new
  /// field with these seeds and this slowness, within a relative 1e-5, as far as it reached (or
  /// less far, where labels rose). Looks only at what changes; starts anew where that is much,
  /// which is told by how long the rim of what has changed is, and by how it goes on. Throws
  /// std::invalid_argument as the constructor does, and for a vertex that does not exist.
  Update update(std::vector<FastMarchingSeed> seeds, ArrayView<float> slowness,
                ArrayView<std::uint32_t> changed, const std::atomic<bool>* cancel);

  /// All labels up to this one are final. Infinite: the field is complete.
  double limit() const { return is_mended_ ? limit_ : -1.0; }

  /// +inf where not reached. Values above the limit are not final.
  ArrayView<double> labels() const;

  /// For each vertex the label where it is final, else +inf.
  std::vector<float> potential() const;

 private:
  void checkSlowness(ArrayView<float> slowness, ArrayView<std::uint32_t> changed) const;
  void prepareSeeds();
  void start(ArrayView<float> slowness);
  bool run(ArrayView<float> slowness, const FastMarchingStop& stop);
  bool mend(ArrayView<float> slowness, ArrayView<std::uint32_t> begins,
            const std::atomic<bool>* cancel, Update& done);
  bool startAgain(ArrayView<float> slowness, const std::atomic<bool>* cancel, Update& done);

  std::shared_ptr<FastMarchingPool> pool_;
  std::unique_ptr<FastMarchingBuffers> buffers_;
  std::vector<FastMarchingSeed> seeds_;
  double limit_ = -1.0;
  bool is_mended_ = true;               // false while a repair has not come to its end
  std::vector<std::uint32_t> changed_;  // labels that this repair has changed so far
};

}  // namespace mesh_map
