#include <mesh_map/bvh/tree/bvh.h>

#include <mesh_map/base/parallel.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "base/float_bits.h"
#include "base/require.h"
#include "base/run.h"
#include "bvh/tree/bvh_boxes.h"
#include "bvh/tree/bvh_bytes.h"
#include "bvh/tree/bvh_check.h"
#include "bvh/tree/bvh_clusters.h"
#include "bvh/tree/bvh_frame.h"
#include "bvh/tree/bvh_subtrees.h"

namespace mesh_map {

namespace {

constexpr double CLUSTER_SHARE = 0.35, SUBTREE_SHARE = 0.6, COPY_SHARE = 0.05;

/// To be filled, but for the tail.
LargeArray<float> newCorners(std::size_t face_count)
{
  LargeArray<float> corners(9 * face_count + Bvh::TAIL);
  std::fill(corners.end() - Bvh::TAIL, corners.end(), 0.0f);
  return corners;
}

}  // namespace

/// Puts a hierarchy together: clusters of triangles along a Morton curve, the top of the tree over
/// these clusters, and then, side by side, subtrees over the triangles. What the parts are does not
/// depend on the number of threads.
class BvhBuilder
{
 public:
  BvhBuilder(Bvh& bvh, const MeshView& mesh, Run& run) : bvh_(bvh), mesh_(mesh), run_(run) {}

  void build()
  {
    const FaceSample sample(mesh_);
    bvh_.center_ = sample.center();
    const LocalFrame frame(bvh_.center_);
    const BvhClusters clusters = findClusters(mesh_, sample, frame, run_, CLUSTER_SHARE);
    top_ = makeTop(clusters, run_);

    const std::size_t count = mesh_.faceCount();
    bvh_.faces_ = LargeArray<std::uint32_t>(count);
    bvh_.corners_ = newCorners(count);
    BvhSubtreeMaker maker(mesh_, frame, clusters, top_, run_);
    run_.each(top_.subtrees.size(), 1, SUBTREE_SHARE, [this, maker](std::size_t i) mutable {
      maker.make(top_.subtrees[i], bvh_.faces_.data(), bvh_.corners_.data());
    });
    join();
    bvh_.setBox();
  }

 private:
  /// Brings all nodes into depth-first order.
  void join()
  {
    std::size_t total = top_.nodes.size();
    for (const BvhSubtree& subtree : top_.subtrees) {
      total += subtree.nodes.size();
    }
    bvh_.nodes_ = LargeArray<BvhNode>(total);
    offsets_.resize(top_.subtrees.size());
    if (top_.nodes.empty()) {
      offsets_[0] = 0;
    } else {
      placeTop(0);
    }
    run_.each(top_.subtrees.size(), 1, COPY_SHARE,
              [this](std::size_t i) { placeSubtree(top_.subtrees[i], offsets_[i]); });
  }

  /// Returns what BvhNode::child says.
  std::uint32_t placeTop(std::uint32_t index)
  {
    const std::uint32_t place = next_++;
    BvhNode node = top_.nodes[index];
    for (std::uint32_t& child : node.child) {
      if (!isLeaf(child)) {
        child = placeTop(child);
      } else if (child != BVH_NO_CHILD) {
        const std::uint32_t i = child & ~BVH_LEAF;
        const BvhSubtree& subtree = top_.subtrees[i];
        offsets_[i] = next_;
        child = subtree.isLeaf() ? BVH_LEAF | subtree.first : next_;
        next_ += static_cast<std::uint32_t>(subtree.nodes.size());
      }
    }
    bvh_.nodes_[place] = node;
    return place;
  }

  void placeSubtree(BvhSubtree& subtree, std::uint32_t offset)
  {
    BvhNode* to = bvh_.nodes_.data() + offset;
    for (const BvhNode& node : subtree.nodes) {
      *to = node;
      for (std::uint32_t& child : to->child) {
        child += isLeaf(child) ? 0 : offset;
      }
      ++to;
    }
    subtree.nodes = {};
  }

  Bvh& bvh_;
  const MeshView& mesh_;
  Run& run_;
  BvhTop top_;
  std::vector<std::uint32_t> offsets_;  // of the nodes of subtrees
  std::uint32_t next_ = 0;
};

Bvh Bvh::build(const MeshView& mesh, const BvhOptions& options)
{
  Run run(options);
  run.check();
  checkFaceCount(mesh);
  Bvh bvh;
  BvhBuilder(bvh, mesh, run).build();
  run.finish();
  return bvh;
}

void Bvh::setBox()
{
  const FloatBox box = boxOf(nodes_[0]);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    lower_[axis] = box.lower[static_cast<int>(axis)];
    upper_[axis] = box.upper[static_cast<int>(axis)];
  }
}

std::size_t Bvh::memory() const
{
  return nodes_.capacity() * sizeof(BvhNode) + corners_.capacity() * sizeof(float) +
         faces_.capacity() * sizeof(std::uint32_t);
}

namespace {

constexpr double CHECK_SHARE = 0.2;

}  // namespace

void Bvh::refit(const MeshView& mesh, const BvhOptions& options)
{
  Run run(options);
  run.check();
  require(mesh.faceCount() == faceCount(), "the mesh has " + std::to_string(mesh.faceCount()) +
                                               " faces, but the spatial index is one of " +
                                               std::to_string(faceCount()) +
                                               ": build a new one where faces have changed");
  checkMesh(mesh, run, CHECK_SHARE);

  // All is made anew and then exchanged, so that nothing has changed where something is thrown.
  LargeArray<BvhNode> nodes(nodes_);
  LargeArray<float> corners = newCorners(faceCount());
  computeBoxes(
      {mesh, LocalFrame(center_), faces_.data(), nodes.data(), nodes.size(), corners.data()}, run,
      1.0 - CHECK_SHARE);
  run.finish();
  nodes_.swap(nodes);
  corners_.swap(corners);
  setBox();
}

// The form of serialize(): the header, then per node, depth first, the triangles below each of its
// children, which is all there is to know of a tree whose children are leaves where they fit in,
// then the faces in the order of the leaves, then a checksum. Boxes and corners follow from the
// mesh.

namespace {

constexpr std::uint64_t MAGIC = 0x6876625F6873656Du;  // "mesh_bvh"
constexpr std::uint32_t VERSION = 1;
constexpr std::size_t HEADER = 8 + 4 + 4 + 4 + 3 * 4 + 8;
constexpr std::size_t CHECKSUM = 8;
constexpr std::size_t FACES_PER_CHUNK = 65536;

/// Sums up the hashes of all faces.
template <class Hash>
std::uint64_t geometryHash(std::size_t count, const Hash& hash)
{
  std::atomic<std::uint64_t> sum{0};
  parallelFor(count, FACES_PER_CHUNK, 0, [&]() -> RangeBody {
    return [&](std::size_t begin, std::size_t end) {
      std::uint64_t part = 0;
      for (std::size_t i = begin; i < end; ++i) {
        part += hash(i);
      }
      sum += part;
    };
  });
  return sum;
}

[[noreturn]] void refuse(const std::string& what)
{
  throw std::invalid_argument("not the bytes of a spatial index of this mesh: " + what +
                              "; build the index anew");
}

std::string differ(const char* what, std::uint64_t found, std::uint64_t expected)
{
  return std::to_string(found) + " " + what + " where " + std::to_string(expected) + " belong";
}

/// Makes nodes (without boxes) of the numbers of triangles below their children.
class NodeReader
{
 public:
  NodeReader(const std::uint8_t* bytes, LargeArray<BvhNode>& nodes) : bytes_(bytes), nodes_(nodes)
  {
  }

  void read(std::size_t count)
  {
    readNode(0, static_cast<std::uint32_t>(count));
    if (next_ != nodes_.size()) {
      refuse(differ("nodes", nodes_.size(), next_));
    }
  }

 private:
  void readNode(std::size_t level, std::uint32_t count)
  {
    if (level == BVH_DEPTH) {
      refuse("the tree is deeper than " + std::to_string(BVH_DEPTH) + " nodes");
    }
    if (next_ == nodes_.size()) {
      refuse("nodes are missing after the last one, " + std::to_string(next_ - 1));
    }
    const std::size_t index = next_++;
    std::uint64_t sum = 0;
    BvhNode node = {};
    for (std::size_t k = 0; k < BVH_WIDTH; ++k) {
      node.count[k] = readNumber<std::uint32_t>(bytes_ + 4 * (BVH_WIDTH * index + k));
      sum += node.count[k];
    }
    if (sum != count) {
      refuse("node " + std::to_string(index) + " has " + differ("triangles", sum, count));
    }
    for (std::size_t k = 0; k < BVH_WIDTH; ++k) {
      node.child[k] = BVH_NO_CHILD;
      if (node.count[k] > BVH_LEAF_SIZE) {
        node.child[k] = static_cast<std::uint32_t>(next_);
        readNode(level + 1, node.count[k]);
      } else if (node.count[k] > 0) {
        node.child[k] = BVH_LEAF | triangles_;
        triangles_ += node.count[k];
      }
    }
    nodes_[index] = node;
  }

  const std::uint8_t* bytes_;
  LargeArray<BvhNode>& nodes_;
  std::size_t next_ = 0;
  std::uint32_t triangles_ = 0;
};

/// Reads the faces, and sees that each is there once.
void readFaces(const std::uint8_t* bytes, LargeArray<std::uint32_t>& faces)
{
  std::vector<bool> found(faces.size());
  for (std::size_t i = 0; i < faces.size(); ++i) {
    faces[i] = readNumber<std::uint32_t>(bytes + 4 * i);
    if (faces[i] >= faces.size()) {
      refuse("face " + std::to_string(faces[i]) + " at position " + std::to_string(i) + " of " +
             std::to_string(faces.size()));
    }
    if (found[faces[i]]) {
      refuse("face " + std::to_string(faces[i]) + " a second time at position " +
             std::to_string(i));
    }
    found[faces[i]] = true;
  }
}

}  // namespace

std::vector<std::uint8_t> Bvh::serialize() const
{
  ByteWriter writer(HEADER + 4 * BVH_WIDTH * nodes_.size() + 4 * faces_.size() + CHECKSUM);
  writer.write(MAGIC);
  writer.write(VERSION);
  writer.write(static_cast<std::uint32_t>(faces_.size()));
  writer.write(static_cast<std::uint32_t>(nodes_.size()));
  for (const float value : center_) {
    writer.write(bitsOf(value));
  }
  writer.write(geometryHash(faces_.size(), [this](std::size_t i) {
    const float* const corners = corners_.data() + 9 * i;
    return faceHash(faces_[i], corners, corners + 3, corners + 6);
  }));
  for (const BvhNode& node : nodes_) {
    for (const std::uint32_t count : node.count) {
      writer.write(count);
    }
  }
  for (const std::uint32_t face : faces_) {
    writer.write(face);
  }
  writer.write(checksum(writer.bytes().data(), writer.bytes().size()));
  return std::move(writer.bytes());
}

Bvh Bvh::deserialize(ArrayView<std::uint8_t> bytes, const MeshView& mesh)
{
  Run run({});
  checkMesh(mesh, run, 0.0);
  if (bytes.size() < HEADER + CHECKSUM) {
    refuse(std::to_string(bytes.size()) + " bytes are too few");
  }
  const std::uint8_t* at = bytes.data();
  if (readNumber<std::uint64_t>(at) != MAGIC) {
    refuse("they do not begin as such");
  }
  if (readNumber<std::uint32_t>(at + 8) != VERSION) {
    refuse("version " + std::to_string(readNumber<std::uint32_t>(at + 8)) + " is not " +
           std::to_string(VERSION) + ", which is read");
  }
  const std::size_t faces = readNumber<std::uint32_t>(at + 12);
  const std::size_t nodes = readNumber<std::uint32_t>(at + 16);
  if (faces != mesh.faceCount()) {
    refuse(differ("faces", faces, mesh.faceCount()));
  }
  const std::uint64_t size =
      HEADER + std::uint64_t{4 * BVH_WIDTH} * nodes + std::uint64_t{4} * faces + CHECKSUM;
  if (bytes.size() != size) {
    refuse(differ("bytes", bytes.size(), size));
  }
  if (checksum(at, bytes.size() - CHECKSUM) !=
      readNumber<std::uint64_t>(at + bytes.size() - CHECKSUM)) {
    refuse("they are damaged (the checksum differs)");
  }

  Bvh bvh;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    bvh.center_[axis] = floatOf(readNumber<std::uint32_t>(at + 20 + 4 * axis));
    if (!(std::abs(bvh.center_[axis]) <= LocalFrame::LARGEST_CENTER)) {
      refuse("a center at " + std::to_string(bvh.center_[axis]));
    }
  }
  const std::uint64_t hash = geometryHash(faces, [&mesh](std::size_t face) {
    return faceHash(static_cast<std::uint32_t>(face), mesh.corner(face, 0), mesh.corner(face, 1),
                    mesh.corner(face, 2));
  });
  if (hash != readNumber<std::uint64_t>(at + 32)) {
    refuse("it is one of a mesh whose faces are elsewhere");
  }
  bvh.nodes_ = LargeArray<BvhNode>(nodes);
  NodeReader(at + HEADER, bvh.nodes_).read(faces);
  bvh.faces_ = LargeArray<std::uint32_t>(faces);
  readFaces(at + HEADER + 4 * BVH_WIDTH * nodes, bvh.faces_);
  bvh.corners_ = newCorners(faces);
  computeBoxes({mesh, LocalFrame(bvh.center_), bvh.faces_.data(), bvh.nodes_.data(), nodes,
                bvh.corners_.data()},
               run, 0.0);
  bvh.setBox();
  return bvh;
}

}  // namespace mesh_map
