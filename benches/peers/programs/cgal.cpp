// CGAL's tree of triangles, with exact constructions, or with -DINEXACT with exact predicates only.

#include <limits>

#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Exact_predicates_exact_constructions_kernel.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include "tracer.h"

#ifdef INEXACT
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
#else
using Kernel = CGAL::Exact_predicates_exact_constructions_kernel;
#endif

class Tracer {
  using Triangles = std::vector<Kernel::Triangle_3>;
  using Primitive = CGAL::AABB_triangle_primitive<Kernel, Triangles::const_iterator>;
  using Tree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>>;

  Triangles triangles;
  Tree tree;

  static Kernel::Point_3 point(const std::array<double, 3>& p) { return {p[0], p[1], p[2]}; }

 public:
  struct Prepared {
    Kernel::Ray_3 ray;
    // From the origin to the end at t = 1; only for any hits, whose rays end there or nowhere.
    Kernel::Segment_3 segment;
    bool endless;
  };

  explicit Tracer(const std::vector<Corners>& all) {
    triangles.reserve(all.size());
    for (const Corners& c : all) triangles.emplace_back(point(c[0]), point(c[1]), point(c[2]));
    tree.insert(triangles.cbegin(), triangles.cend());
    tree.build();
  }

  Prepared prepare(const Ray& ray) const {
    Kernel::Point_3 origin = point(ray.origin);
    Kernel::Vector_3 dir(ray.dir[0], ray.dir[1], ray.dir[2]);
    bool endless = ray.t_max == std::numeric_limits<double>::infinity();
    Kernel::Point_3 end = origin + dir * Kernel::FT(endless ? 1.0 : ray.t_max);
    return {Kernel::Ray_3(origin, dir), Kernel::Segment_3(origin, end), endless};
  }

  std::int32_t closest(const Prepared& ray) const {
    auto hit = tree.first_intersected_primitive(ray.ray);
    return hit ? std::int32_t(*hit - triangles.cbegin()) : -1;
  }

  bool any(const Prepared& ray) const {
    return ray.endless ? tree.do_intersect(ray.ray) : tree.do_intersect(ray.segment);
  }
};

int main(int count, char** arguments) { return serve<Tracer>(count, arguments); }
