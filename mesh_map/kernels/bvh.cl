// Traversals of a bounding volume hierarchy (mesh_map/bvh/tree/bvh.h) on an OpenCL device: 32-bit
// floats, no recursion. mesh_map/bvh/device/bvh_device.h says what goes in and out, and packs and
// finishes it.
//
// Kernels do not decide: they find the few triangles that may be the answer. Floats carry bounds of
// their errors for that: results are rounded by 2^-24, quotients and roots by 2^-21 (as OpenCL
// allows), and below 2^-126 they may be 0. The host sees to it that products are not too large.

#pragma OPENCL FP_CONTRACT OFF

#define STACK_SIZE 128  // BVH_STACK
#define LEAF 0x80000000u
#define NONE 0xFFFFFFFFu
#define DOUBT 0xFFFFFFFEu
#define BACK_FACES 1u  // flags
#define MASKED 2u
#define ANY_HIT 4u

// mesh_map/bvh/tree/bvh_node.h: the bounds of four boxes, lower ones of x, y, z, then (from UPPER
// on) upper ones, and what is in them.
typedef struct { float4 bounds[6]; uint4 child, count; } Node;
#define UPPER 3u

// Vectors of four triangles.
typedef struct { float4 x, y, z; } Vectors;
typedef struct { Vectors a, b, c; } Corners;

float4 dot4(Vectors a, Vectors b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Vectors cross4(Vectors a, Vectors b) {
  return (Vectors){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
Vectors minus4(Vectors a, Vectors b) { return (Vectors){a.x - b.x, a.y - b.y, a.z - b.z}; }
Vectors times4(Vectors a, float4 b) { return (Vectors){a.x * b, a.y * b, a.z * b}; }
float4 largest(float4 a, float4 b, float4 c) { return max(max(a, b), c); }
float4 smallest(float4 a, float4 b, float4 c) { return min(min(a, b), c); }
float4 largestSize(float4 a, float4 b, float4 c) { return largest(fabs(a), fabs(b), fabs(c)); }

// The corners of boxes that lie at lower (0) or upper (UPPER) bounds.
Vectors boxCorners(global const Node* node, uint x, uint y, uint z) {
  return (Vectors){node->bounds[x], node->bounds[y + 1], node->bounds[z + 2]};
}

// Corners of the four triangles of a leaf, coordinates in the order of axes, seen from head + tail,
// which is a double precision number to 2^-46 of it. Wrong by two roundings of the result (where
// the first difference is not exact it is as large). Numbers behind the last triangle may be read.
float4 coordinates(global const float* at, float head, float tail) {
  return ((float4)(at[0], at[9], at[18], at[27]) - head) - tail;
}
Vectors vectorsFrom(global const float* corner, uint3 axes, float4 head, float4 tail) {
  return (Vectors){coordinates(corner + axes.x, head.x, tail.x),
                   coordinates(corner + axes.y, head.y, tail.y),
                   coordinates(corner + axes.z, head.z, tail.z)};
}
Corners cornersFrom(global const float* leaf, uint3 axes, float4 head, float4 tail) {
  return (Corners){vectorsFrom(leaf, axes, head, tail), vectorsFrom(leaf + 3, axes, head, tail),
                   vectorsFrom(leaf + 6, axes, head, tail)};
}

// What is sorted by a bound (a float that is not negative): the bound above, a number below.
ulong makeKey(float bound, uint number) { return (ulong)as_uint(bound) << 32 | number; }
float keyBound(ulong key) { return as_float((uint)(key >> 32)); }

// A subtree to be looked at: a bound of its distance and BvhNode::child. The lowest three bits of
// the bound give way to the count of a leaf, which makes the bound smaller, which is safe.
ulong makeTask(float bound, uint child, uint count) {
  return makeKey(as_float((as_uint(bound) & ~7u) | (count & 7u)), child);
}
float taskBound(ulong task) { return keyBound(task & ~(7ul << 32)); }
uint taskCount(ulong task) { return (uint)(task >> 32) & 7u; }

// Puts the children that are wanted (-1, else 0) onto the stack, the one of the least bound last.
// Returns the new size. Writes four in any case.
uint pushChildren(ulong* stack, uint size, global const Node* node, float4 bounds, int4 wanted) {
  const uint4 child = node->child, count = node->count;
  const ulong a = wanted.s0 ? makeTask(bounds.s0, child.s0, count.s0) : 0;
  const ulong b = wanted.s1 ? makeTask(bounds.s1, child.s1, count.s1) : 0;
  const ulong c = wanted.s2 ? makeTask(bounds.s2, child.s2, count.s2) : 0;
  const ulong d = wanted.s3 ? makeTask(bounds.s3, child.s3, count.s3) : 0;
  // A sorting network; what is not wanted comes last.
  const ulong ab = max(a, b), ba = min(a, b), cd = max(c, d), dc = min(c, d);
  const ulong middle = max(ba, dc), other = min(ab, cd);
  stack[size] = max(ab, cd);
  stack[size + 1] = max(middle, other);
  stack[size + 2] = min(middle, other);
  stack[size + 3] = min(ba, dc);
  return size - (uint)(wanted.s0 + wanted.s1 + wanted.s2 + wanted.s3);
}

// The few triangles that may be the answer, by rising lower bounds of their distance, and one more:
// the nearest that found no room.
void clearCandidates(ulong* found, const uint room, bool doubt) {
  for (uint i = 0; i < room; ++i) {
    found[i] = makeKey(INFINITY, NONE);
  }
  found[room] = makeKey(doubt ? 0.0f : INFINITY, NONE);
}
void addCandidate(ulong* found, const uint room, float bound, uint triangle) {
  ulong key = makeKey(max(bound, 0.0f), triangle);
  for (uint i = 0; i < room; ++i) {
    const ulong other = found[i];
    found[i] = min(key, other);
    key = max(key, other);
  }
  found[room] = min(found[room], key);
}
void writeCandidates(const ulong* found, const uint room, float limit, global uint* answers) {
  for (uint i = 0; i < room; ++i) {
    answers[i] = keyBound(found[i]) <= limit ? (uint)found[i] : NONE;
  }
  answers[0] = keyBound(found[room]) <= limit ? DOUBT : answers[0];
}

#define RAY_ANSWERS 4u
// With x, y, z being the axes of RayTest (mesh_map/bvh/rays/bvh_rays.h): a line over z, slopes.xy,
// through head + tail. Depth is the way along z from there on, limited by head.w. In tail.w:
// axesOf().
typedef struct { float4 head, tail, slopes, errors; } PackedRay;

// Axes x, y, z, and 1 where the ray runs against the last.
uint4 axesOf(uint code) { return ((uint4)(code) >> (uint4)(0, 2, 4, 6)) & 3; }

// Returns whether there is a hit for sure. Its bounds are derived in bvh_device.cpp.
bool castAtLeaf(global const float* corners, global const uchar* mask, uint flags, uint first,
                uint count, const PackedRay* ray, float* limit, ulong* found) {
  const uint4 axes = axesOf(as_uint(ray->tail.w));
  Corners t = cornersFrom(corners + 9 * (size_t)first, axes.xyz, ray->head, ray->tail);
  const float sign = axes.w ? -1.0f : 1.0f, shear_x = ray->slopes.x, shear_y = ray->slopes.y;
  t.a.x -= shear_x * t.a.z, t.b.x -= shear_x * t.b.z, t.c.x -= shear_x * t.c.z;
  t.a.y -= shear_y * t.a.z, t.b.y -= shear_y * t.b.z, t.c.y -= shear_y * t.c.z;
  // U, V, W of S. Woop, C. Benthin, I. Wald: Watertight Ray/Triangle Intersection, 2013
  const float4 u = t.c.x * t.b.y - t.c.y * t.b.x;
  const float4 v = t.a.x * t.c.y - t.a.y * t.c.x;
  const float4 w = t.b.x * t.a.y - t.b.y * t.a.x;
  const float4 m = max(largestSize(t.a.x, t.b.x, t.c.x), largestSize(t.a.y, t.b.y, t.c.y));
  const float4 away = largestSize(t.a.z, t.b.z, t.c.z);
  const float4 e = ray->errors.x + 0x1p-22f * m + 0x1p-21f * away;
  const float4 bound = (m * 0x1p-21f + e * 4.01f) * m + (e * e * 2.01f + 1e-36f);
  const float4 least = smallest(u, v, w), most = largest(u, v, w);
  const int4 backs = (flags & BACK_FACES) ? (int4)(-1) : (int4)(0);
  const int4 perhaps =
      (~(least < -bound) | (~(most > bound) & backs)) & ((int4)(0, 1, 2, 3) < (int4)((int)count));
  if (!any(perhaps)) {
    return false;
  }
  const int4 sure = (least > bound) | ((most < -bound) & backs);
  const float4 a = t.a.z * sign, b = t.b.z * sign, c = t.c.z * sign;
  const float4 error = ray->errors.y + 0x1p-22f * away;
  const float4 nearest = smallest(a, b, c) - error, farthest = largest(a, b, c) + error;
  // Divided first: the cube of a size may be no float.
  const float4 inverse = 1.0f / (sure ? u + v + w : (float4)(1.0f));
  const float4 depth = a + (v * inverse * (b - a) + w * inverse * (c - a));
  const float4 inexact = (farthest - nearest) * (4.0f * bound * fabs(inverse) + 0x1p-19f) + error;
  const float4 low = sure ? max(depth - inexact, nearest) : nearest;
  const float4 high = sure ? min(depth + inexact, farthest) : farthest;
  bool enough = false;
  const float *lows = (const float*)&low, *highs = (const float*)&high;
  for (uint k = 0; k < 4; ++k) {
    // Negative depths are behind the origin.
    if (!((const int*)&perhaps)[k] || highs[k] < 0.0f || lows[k] > *limit ||
        ((flags & MASKED) && mask[first + k] == 0)) {
      continue;
    }
    if (((const int*)&sure)[k] && lows[k] > 0.0f) {
      // The limit may be that of the maximum distance, rounded up.
      enough = enough || highs[k] * (1.0f + 0x1p-20f) + 4.0f * ray->errors.y < *limit;
      *limit = min(*limit, highs[k]);
    }
    addCandidate(found, RAY_ANSWERS, lows[k], first + k);
  }
  return enough;
}

kernel void cast_rays(global const Node* nodes, global const float* corners,
                      global const PackedRay* rays, global const uchar* mask, uint flags,
                      uint ray_count, global uint* answers) {
  const uint item = get_global_id(0);
  if (item >= ray_count) {
    return;
  }
  const PackedRay ray = rays[(size_t)item + 1];  // after what is packed of the mesh
  const uint code = as_uint(ray.tail.w);
  float limit = ray.head.w;
  ulong found[RAY_ANSWERS + 1];
  clearCandidates(found, RAY_ANSWERS, code == DOUBT);
  ulong stack[STACK_SIZE];
  stack[0] = makeTask(0.0f, 0, 0);
  uint size = code == DOUBT || code == NONE ? 0 : 1;
  const uint4 axes = axesOf(code);
  // Boxes, in local coordinates. A plane is at the depth (plane - start) / slope. The start moves
  // towards near planes and away from far ones by the error, and 2^-21 covers three roundings.
  global const float* center = (global const float*)rays;
  const float4 along = (float4)(center[axes.x], center[axes.y], center[axes.z], 0.0f);
  const float4 start = (ray.head - along) + ray.tail;
  const float4 inverse = (float4)(ray.slopes.zw, axes.w ? -1.0f : 1.0f, 1.0f);
  const float4 margin = copysign((float4)(ray.errors.z), inverse);
  const float4 near_start = start + margin, far_start = start - margin;
  const float4 near_inverse = inverse * (1.0f - 0x1p-21f);
  const float4 far_inverse = inverse * (1.0f + 0x1p-21f);
  const uint4 near = axes + (inverse < 0.0f ? (uint4)(UPPER) : (uint4)(0));
  const uint4 far = 2 * axes + UPPER - near;
  while (size > 0) {
    const ulong task = stack[--size];
    if (taskBound(task) > limit) {
      continue;
    }
    const uint child = (uint)task;
    if (child & LEAF) {
      const bool enough = castAtLeaf(corners, mask, flags, child & ~LEAF, taskCount(task), &ray,
                                     &limit, found);
      size = enough && (flags & ANY_HIT) ? 0 : size;
      continue;
    }
    global const Node* node = nodes + child;
    // slabs: T. Kay, J. Kajiya: Ray Tracing Complex Scenes, 1986
    const float4 enter = largest((node->bounds[near.x] - near_start.x) * near_inverse.x,
                                 (node->bounds[near.y] - near_start.y) * near_inverse.y,
                                 max((node->bounds[near.z] - near_start.z) * near_inverse.z, 0.0f));
    const float4 leave = smallest((node->bounds[far.x] - far_start.x) * far_inverse.x,
                                  (node->bounds[far.y] - far_start.y) * far_inverse.y,
                                  min((node->bounds[far.z] - far_start.z) * far_inverse.z, limit));
    size = pushChildren(stack, size, node, enter, (enter <= leave) & (node->count != 0));
  }
  writeCandidates(found, RAY_ANSWERS, limit, answers + RAY_ANSWERS * (size_t)item);
}

#define POINT_ANSWERS 8u
typedef struct { float4 head, tail; } PackedPoint;

// How far triangles are at least along a direction or its opposite, up to rounding. A direction so
// small that its square loses digits says nothing.
float4 distanceAlong(Corners t, Vectors direction) {
  const float4 a = dot4(direction, t.a), b = dot4(direction, t.b), c = dot4(direction, t.c);
  const float4 least = max(smallest(a, b, c), -largest(a, b, c));
  const float4 squared = dot4(direction, direction);
  const int4 enough = squared >= 1e-25f;
  return enough ? least / sqrt(enough ? squared : (float4)(1.0f)) : (float4)(0.0f);
}

// Takes the point of an edge that is nearest to 0, if it is nearer.
void tryEdge(Vectors start, Vectors edge, Vectors* nearest, float4* squared) {
  const float4 along = -dot4(start, edge) / max(dot4(edge, edge), (float4)(1e-30f));
  const Vectors step = times4(edge, clamp(along, 0.0f, 1.0f));
  const Vectors point = {start.x + step.x, start.y + step.y, start.z + step.z};
  const float4 other = dot4(point, point);
  const int4 nearer = other < *squared;
  nearest->x = nearer ? point.x : nearest->x;
  nearest->y = nearer ? point.y : nearest->y;
  nearest->z = nearer ? point.z : nearest->z;
  *squared = nearer ? other : *squared;
}

// Bounds of the distances of triangles from 0: bvh_device.cpp says why they are.
void distanceBounds(Corners t, float error, float4* low, float4* high) {
  const Vectors u = minus4(t.b, t.a), v = minus4(t.c, t.a), n = cross4(u, v);
  Vectors nearest = t.a;
  float4 squared = dot4(t.a, t.a);
  const float4 far_squared = largest(squared, dot4(t.b, t.b), dot4(t.c, t.c));
  tryEdge(t.a, u, &nearest, &squared);
  tryEdge(t.a, v, &nearest, &squared);
  tryEdge(t.b, minus4(v, u), &nearest, &squared);
  const float4 lower = max(distanceAlong(t, nearest), distanceAlong(t, n));
  // The foot on the plane, where it lies in the triangle: weights are the areas across.
  const float4 a = dot4(cross4(t.b, t.c), n);
  const float4 b = dot4(cross4(t.c, t.a), n);
  const float4 c = dot4(cross4(t.a, t.b), n);
  const float4 sum = a + b + c;
  const int4 inside = (a >= 0.0f) & (b >= 0.0f) & (c >= 0.0f) & (sum > 1e-30f) & (sum < 1e37f);
  // Divided first: areas times coordinates may be no floats, or vanish.
  const float4 inverse = 1.0f / (inside ? sum : (float4)(1.0f));
  const Vectors on_a = times4(t.a, a * inverse), on_b = times4(t.b, b * inverse);
  const Vectors on_c = times4(t.c, c * inverse);
  const Vectors foot = {on_a.x + on_b.x + on_c.x, on_a.y + on_b.y + on_c.y,
                        on_a.z + on_b.z + on_c.z};
  squared = inside ? min(squared, dot4(foot, foot)) : squared;
  const float4 rounding = sqrt(far_squared) * 0x1p-20f + error;
  *low = max(lower * (1.0f - 0x1p-18f) - rounding, 0.0f);
  *high = sqrt(squared) * (1.0f + 0x1p-18f) + rounding;
}

// No more than the squares of the distances of boxes from a point, which is wrong by the margin.
float4 squaredGaps(global const Node* node, float4 point, float margin) {
  const Vectors low = boxCorners(node, 0, 0, 0), high = boxCorners(node, UPPER, UPPER, UPPER);
  const Vectors gap = {max(max(low.x - point.x, point.x - high.x) - margin, 0.0f),
                       max(max(low.y - point.y, point.y - high.y) - margin, 0.0f),
                       max(max(low.z - point.z, point.z - high.z) - margin, 0.0f)};
  return dot4(gap, gap) * (1.0f - 0x1p-20f);
}

kernel void closest_points(global const Node* nodes, global const float* corners,
                           global const PackedPoint* points, global const uchar* mask, uint flags,
                           uint point_count, global uint* answers) {
  const uint item = get_global_id(0);
  if (item >= point_count) {
    return;
  }
  const float4 head = points[(size_t)item + 1].head, tail = points[(size_t)item + 1].tail;
  const float4 place = (head - points[0].head) + tail;  // in local coordinates
  const float error = 0x1p-44f * (fabs(head.x) + fabs(head.y) + fabs(head.z)) + 1e-17f;
  float limit = head.w;
  ulong found[POINT_ANSWERS + 1];
  clearCandidates(found, POINT_ANSWERS, tail.w < 0.0f);
  ulong stack[STACK_SIZE];
  stack[0] = makeTask(0.0f, 0, 0);
  uint size = limit >= 0.0f && tail.w >= 0.0f ? 1 : 0;
  float squared_limit = limit * limit * (1.0f + 0x1p-20f);
  while (size > 0) {
    const ulong task = stack[--size];
    if (taskBound(task) > squared_limit) {
      continue;
    }
    const uint child = (uint)task;
    if (!(child & LEAF)) {
      global const Node* node = nodes + child;
      const float4 squared = squaredGaps(node, place, tail.w);
      const int4 wanted = (squared <= squared_limit) & (node->count != 0);
      size = pushChildren(stack, size, node, squared, wanted);
      continue;
    }
    const uint first = child & ~LEAF;
    float4 low, high;
    const Corners t = cornersFrom(corners + 9 * (size_t)first, (uint3)(0, 1, 2), head, tail);
    distanceBounds(t, error, &low, &high);
    for (uint k = 0; k < taskCount(task); ++k) {
      const float bound = ((const float*)&low)[k];
      if (!(bound > limit) && !((flags & MASKED) && mask[first + k] == 0)) {
        limit = min(limit, ((const float*)&high)[k]);
        addCandidate(found, POINT_ANSWERS, bound, first + k);
      }
    }
    squared_limit = limit * limit * (1.0f + 0x1p-20f);
  }
  writeCandidates(found, POINT_ANSWERS, limit, answers + POINT_ANSWERS * (size_t)item);
}

#define OUTSIDE 0  // verdicts
#define TOUCHING 1
#define INSIDE 2
#define UNSURE 3

// A subtree of a selection: BvhNode::child and the position of the first triangle; of a leaf the
// count. Marks children that are inside, and puts those that may be touched onto the stack.
uint pushSubtrees(uint2* stack, uint stacked, global const Node* node, uint first, int4 outside,
                  int4 inside, global uchar* verdicts) {
  for (uint k = 0; k < 4; ++k) {
    const uint child = ((global const uint*)&node->child)[k];
    const uint count = ((global const uint*)&node->count)[k];
    if (((const int*)&outside)[k] == 0 && ((const int*)&inside)[k] != 0) {
      for (uint i = first; i < first + count; ++i) {
        verdicts[i] = INSIDE;
      }
    } else if (((const int*)&outside)[k] == 0 && count != 0) {
      stack[stacked++] = (uint2)(child, (child & LEAF) ? count : first);
    }
    first += count;
  }
  return stacked;
}

void writeVerdicts(global uchar* verdicts, uint first, uint count, int4 touching, int4 inside,
                   int4 outside) {
  const int4 sides = outside ? (int4)(OUTSIDE)
                     : inside ? (int4)(INSIDE) : touching ? (int4)(TOUCHING) : (int4)(UNSURE);
  for (uint k = 0; k < count; ++k) {
    verdicts[first + k] = (uchar)((const int*)&sides)[k];
  }
}

// region: the center in two parts (w: the radius, rounded down, and up), the center in local
// coordinates (w: bound of its error), bound of what the region rounds.
kernel void select_sphere(global const Node* nodes, global const float* corners,
                          global const float4* region, global const uint2* roots, uint root_count,
                          global uchar* verdicts) {
  const uint item = get_global_id(0);
  const float4 head = region[0], tail = region[1], place = region[2];
  const float margin = place.w, error = region[3].x, least = head.w, most = tail.w;
  uint2 stack[STACK_SIZE];
  uint stacked = item < root_count ? 1 : 0;
  stack[0] = roots[stacked * item];
  while (stacked > 0) {
    const uint2 task = stack[--stacked];
    if (!(task.x & LEAF)) {
      global const Node* node = nodes + task.x;
      const float4 nearest = sqrt(squaredGaps(node, place, margin)) * (1.0f - 0x1p-18f);
      const Vectors low = boxCorners(node, 0, 0, 0), high = boxCorners(node, UPPER, UPPER, UPPER);
      const Vectors reach = {max(place.x - low.x, high.x - place.x) + margin,
                             max(place.y - low.y, high.y - place.y) + margin,
                             max(place.z - low.z, high.z - place.z) + margin};
      const float4 farthest = sqrt(dot4(reach, reach)) * (1.0f + 0x1p-18f);
      stacked = pushSubtrees(stack, stacked, node, task.y, nearest > most + error,
                             farthest < least - error, verdicts);
      continue;
    }
    const uint first = task.x & ~LEAF;
    const Corners t = cornersFrom(corners + 9 * (size_t)first, (uint3)(0, 1, 2), head, tail);
    float4 low, high;
    distanceBounds(t, error, &low, &high);
    const float4 farthest = sqrt(largest(dot4(t.a, t.a), dot4(t.b, t.b), dot4(t.c, t.c)));
    const int4 beyond = farthest * (1.0f - 0x1p-18f) - error > most;
    writeVerdicts(verdicts, first, task.y, (high < least) & beyond,
                  farthest * (1.0f + 0x1p-18f) + error < least, low > most);
  }
}

// How far points are in front of a plane.
float4 height(float4 plane, Vectors point) {
  return plane.x * point.x + plane.y * point.y + plane.z * point.z + plane.w;
}

// region: the center of the mesh, then for each plane it in local coordinates, and a bound of what
// the region rounds. Heights are wrong by less than that and 2^-21 of the size of their terms.
kernel void select_planes(global const Node* nodes, global const float* corners,
                          global const float4* region, uint plane_count, global const uint2* roots,
                          uint root_count, global uchar* verdicts) {
  const uint item = get_global_id(0);
  uint2 stack[STACK_SIZE];
  uint stacked = item < root_count ? 1 : 0;
  stack[0] = roots[stacked * item];
  while (stacked > 0) {
    const uint2 task = stack[--stacked];
    const uint first = task.x & ~LEAF, leaf = task.x & LEAF;
    global const Node* node = nodes + (leaf ? 0 : task.x);
    Corners t;
    t.a = boxCorners(node, 0, 0, 0);
    t.b = t.c = boxCorners(node, UPPER, UPPER, UPPER);
    if (leaf) {
      t = cornersFrom(corners + 9 * (size_t)first, (uint3)(0, 1, 2), region[0], (float4)(0.0f));
    }
    const Vectors size = {largestSize(t.a.x, t.b.x, t.c.x), largestSize(t.a.y, t.b.y, t.c.y),
                          largestSize(t.a.z, t.b.z, t.c.z)};
    int4 outside = (int4)(0), cut = (int4)(0);
    int4 a_inside = (int4)(-1), b_inside = (int4)(-1), c_inside = (int4)(-1);
    for (uint i = 1; i < 2 * plane_count; i += 2) {
      const float4 plane = region[i];
      const float4 error = height(fabs(plane), size) * 0x1p-21f + region[i + 1].x;
      if (!leaf) {  // corners of boxes: the last in front and the first
        const uint x = plane.x < 0.0f ? UPPER : 0, y = plane.y < 0.0f ? UPPER : 0;
        const uint z = plane.z < 0.0f ? UPPER : 0;
        t.a = boxCorners(node, x, y, z);
        t.b = t.c = boxCorners(node, UPPER - x, UPPER - y, UPPER - z);
      }
      const float4 a = height(plane, t.a), b = height(plane, t.b), c = height(plane, t.c);
      outside |= largest(a, b, c) < -error;
      cut |= smallest(a, b, c) < -error;
      a_inside &= a > error, b_inside &= b > error, c_inside &= c > error;
    }
    const int4 inside = a_inside & b_inside & c_inside;
    if (leaf) {
      const int4 touching = (a_inside | b_inside | c_inside) & cut;
      writeVerdicts(verdicts, first, task.y, touching, inside, outside);
    } else {
      stacked = pushSubtrees(stack, stacked, node, task.y, outside, inside, verdicts);
    }
  }
}
