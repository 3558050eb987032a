// Packets of LANES rays: included once per instruction set, in a namespace of its own, where Lanes
// is a vector of LANES floats and LaneInts one of as many integers. No include guard, therefore,
// and no templates: they would be compiled for the instruction set of whoever comes first.

/// As in base/simd.h.
inline Lanes lanesOf(float value)
{
  return Lanes{} + value;
}

/// Rays that go through the tree together: a node is tested for their hull first, and then, where
/// that enters, for each of them.
class Packet
{
 public:
  Packet(const Bvh& bvh, const RayOptions& options, RaySearch* rays)
      : bvh_(bvh), options_(options), rays_(rays)
  {
  }

  /// Takes the rays, if they lie side by side: run along the same axes, have nearly the same slopes
  /// and nearly the same start.
  bool take()
  {
    const Beam& first = rays_[0].beam;
    hull_ = first;
    alive_ = 0;
    std::array<float, 2> lowest_slope = first.shear, highest_slope = first.shear;
    std::array<float, 3> lowest = first.near_origin, highest = first.near_origin;
    for (unsigned lane = 0; lane < LANES; ++lane) {
      const Beam& beam = rays_[lane].beam;
      if (beam.reach != Beam::Reach::FLOATS || beam.near_plane != first.near_plane) {
        return false;
      }
      limits_[lane] = rays_[lane].limit;
      for (unsigned k = 0; k < 3; ++k) {
        near_origin_[k][lane] = beam.near_origin[k];
        far_origin_[k][lane] = beam.far_origin[k];
        near_inverse_[k][lane] = beam.near_inverse[k];
        far_inverse_[k][lane] = beam.far_inverse[k];
        lowest[k] = std::min(lowest[k], beam.near_origin[k]);
        highest[k] = std::max(highest[k], beam.near_origin[k]);
        widen(beam, k);
      }
      for (unsigned k = 0; k < 2; ++k) {
        lowest_slope[k] = std::min(lowest_slope[k], beam.shear[k]);
        highest_slope[k] = std::max(highest_slope[k], beam.shear[k]);
      }
    }
    bool close = true;
    for (unsigned k = 0; k < 3; ++k) {
      const unsigned axis = first.axes[k];
      close = close && highest[k] - lowest[k] <= NEAR * (bvh_.upper()[axis] - bvh_.lower()[axis]);
    }
    for (unsigned k = 0; k < 2; ++k) {
      close = close && highest_slope[k] - lowest_slope[k] <= NEAR;
    }
    return close;
  }

  void search(bool any)
  {
    Task stack[BVH_STACK];
    std::size_t size = 0;
    stack[size++] = {0, 0, 0.0f, (1u << LANES) - 1};
    alive_ = (1u << LANES) - 1;
    findLimit();
    while (size > 0) {
      const Task task = stack[--size];
      const unsigned lanes = task.lanes & alive_;
      if (task.depth > limit_ || lanes == 0) {
        continue;
      }
      if ((lanes & (lanes - 1)) == 0) {
        searchAlone(task, lowestBit(lanes), any);
      } else if (isLeaf(task.child)) {
        searchLeaf(task.child & ~BVH_LEAF, task.count, lanes, any);
      } else {
        size += enter(bvh_.nodes()[task.child], lanes, stack + size);
      }
    }
  }

 private:
  /// As RayTask, for the rays that enter (bits).
  struct Task
  {
    std::uint32_t child;
    std::uint32_t count;
    float depth;
    unsigned lanes;
  };

  static constexpr float NEAR = 0.125f;

  /// Planes of the hull are entered no later and left no earlier than those of any ray.
  void widen(const Beam& beam, unsigned k)
  {
    if (beam.near_inverse[k] > 0.0f) {
      hull_.near_origin[k] = std::max(hull_.near_origin[k], beam.near_origin[k]);
      hull_.far_origin[k] = std::min(hull_.far_origin[k], beam.far_origin[k]);
      hull_.near_inverse[k] = std::min(hull_.near_inverse[k], beam.near_inverse[k]);
      hull_.far_inverse[k] = std::max(hull_.far_inverse[k], beam.far_inverse[k]);
    } else {
      hull_.near_origin[k] = std::min(hull_.near_origin[k], beam.near_origin[k]);
      hull_.far_origin[k] = std::max(hull_.far_origin[k], beam.far_origin[k]);
      hull_.near_inverse[k] = std::max(hull_.near_inverse[k], beam.near_inverse[k]);
      hull_.far_inverse[k] = std::min(hull_.far_inverse[k], beam.far_inverse[k]);
    }
  }

  void findLimit()
  {
    limit_ = limits_[0];
    for (unsigned lane = 1; lane < LANES; ++lane) {
      limit_ = std::max(limit_, limits_[lane]);
    }
  }

  void finish(unsigned lane)
  {
    alive_ &= ~(1u << lane);
    limits_[lane] = -1.0f;
  }

  /// One ray is left.
  void searchAlone(const Task& task, unsigned lane, bool any)
  {
    const RayTask alone = {task.child, task.count, task.depth};
    RaySearch& ray = rays_[lane];
    if (any ? searchTree<true>(bvh_, options_, alone, ray)
            : searchTree<false>(bvh_, options_, alone, ray)) {
      finish(lane);
    } else {
      limits_[lane] = ray.limit;
    }
    findLimit();
  }

  void searchLeaf(std::size_t first, unsigned count, unsigned lanes, bool any)
  {
    const TriangleFilter filter(bvh_.corners().data() + 9 * first);
    const unsigned triangles = (1u << count) - 1;
    bool changed = false;
    for (; lanes != 0; lanes &= lanes - 1) {
      const unsigned lane = lowestBit(lanes);
      RaySearch& ray = rays_[lane];
      for (unsigned hits = filter(ray.beam) & triangles; hits != 0; hits &= hits - 1) {
        if (ray.tryTriangle(bvh_, options_, first + lowestBit(hits))) {
          changed = true;
          limits_[lane] = ray.limit;
          if (any) {
            finish(lane);
            break;
          }
        }
      }
    }
    if (changed) {
      findLimit();
    }
  }

  /// Writes the children of a node that are entered, the nearest last. Returns how many.
  std::size_t enter(const BvhNode& node, unsigned lanes, Task* tasks) const
  {
    const BoxHits boxes = enterBoxes(hull_, node, limit_);
    alignas(16) float depths[BVH_WIDTH];
    std::memcpy(depths, &boxes.depths, sizeof(depths));
    std::size_t size = 0;
    for (unsigned hits = boxes.hits; hits != 0; hits &= hits - 1) {
      const unsigned k = lowestBit(hits);
      const unsigned entering = lanes & enterBox(node, k);
      if (entering == 0) {
        continue;
      }
      prefetch(bvh_, node.child[k]);
      std::size_t place = size++;
      for (; place > 0 && tasks[place - 1].depth < depths[k]; --place) {
        tasks[place] = tasks[place - 1];
      }
      tasks[place] = {node.child[k], node.count[k], depths[k], entering};
    }
    return size;
  }

  /// Rays (bits) that enter a child.
  unsigned enterBox(const BvhNode& node, unsigned child) const
  {
    const float* const planes = node.lower[0] + child;
    Lanes near = lanesOf(0.0f), far = limits_;
    for (unsigned k = 0; k < 3; ++k) {
      near = maximum(near,
                     (lanesOf(planes[hull_.near_plane[k]]) - near_origin_[k]) * near_inverse_[k]);
      far = minimum(far, (lanesOf(planes[hull_.far_plane[k]]) - far_origin_[k]) * far_inverse_[k]);
    }
    return bits(near <= far);
  }

  const Bvh& bvh_;
  const RayOptions& options_;
  RaySearch* rays_;
  Beam hull_;
  Lanes near_origin_[3]{}, far_origin_[3]{}, near_inverse_[3]{}, far_inverse_[3]{};
  Lanes limits_{};
  float limit_ = -1.0f;  // the largest of them
  unsigned alive_ = 0;   // rays that search (bits)
};

void searchRays(const Bvh& bvh, const RayOptions& options, bool any, RaySearch* rays,
                std::size_t count)
{
  for (std::size_t first = 0; first < count; first += LANES) {
    if (first + LANES <= count) {
      Packet packet(bvh, options, rays + first);
      if (packet.take()) {
        packet.search(any);
        continue;
      }
    }
    for (std::size_t i = first; i < std::min<std::size_t>(first + LANES, count); ++i) {
      if (any) {
        searchAll<true>(bvh, options, rays[i]);
      } else {
        searchAll<false>(bvh, options, rays[i]);
      }
    }
  }
}
