// BVH_Double of tinybvh, its tree in f64. TINYBVH_HEADER is the path of tiny_bvh.h, quoted.

#include <limits>

#define TINYBVH_IMPLEMENTATION
#include TINYBVH_HEADER

#include "tracer.h"

class Tracer {
  std::vector<tinybvh::bvhdbl3> corners;
  tinybvh::BVH_Double tree;

  static tinybvh::bvhdbl3 vector(const std::array<double, 3>& p) { return {p[0], p[1], p[2]}; }

 public:
  explicit Tracer(const std::vector<Corners>& triangles) {
    for (const Corners& c : triangles)
      for (const auto& p : c) corners.push_back(vector(p));
    tree.Build(corners.data(), triangles.size());
  }

  // tinybvh normalizes the direction, so t_max becomes a distance.
  tinybvh::RayEx prepare(const Ray& ray) const {
    const auto& d = ray.dir;
    double end = ray.t_max * std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    return {vector(ray.origin), vector(d), std::min(end, BVH_DBL_FAR)};
  }

  std::int32_t closest(tinybvh::RayEx ray) const {
    double end = ray.hit.t;
    tree.Intersect(ray);
    return ray.hit.t < end ? std::int32_t(ray.hit.prim) : -1;
  }

  bool any(const tinybvh::RayEx& ray) const { return tree.IsOccluded(ray); }
};

int main(int count, char** arguments) { return serve<Tracer>(count, arguments); }
