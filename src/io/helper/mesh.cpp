#include "io/helper/mesh.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace tyndall::io {
namespace {

using Point = std::array<double, 3>;
constexpr double steps = 65536;  // per voxel; points are snapped to them

Point cross(const Point& a, const Point& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Point minus(const Point& a, const Point& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
double length(const Point& a) { return std::sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]); }

/// \return the normal of a face, with twice its area as length.
Point normal(const Mesh& mesh, const std::array<std::uint32_t, 3>& t) {
  return cross(minus(mesh.points[t[1]], mesh.points[t[0]]),
               minus(mesh.points[t[2]], mesh.points[t[0]]));
}

/// A face projected along the axis, in integer steps.
struct Projected {
  std::int64_t u[3], v[3];
};

/// \return whether a lattice point is left of the edge from i to j. The test is exact, and treats
/// the point as moved by an infinitesimal step along u and a still smaller one along v: no point
/// lies on an edge, and faces that share an edge agree.
bool is_left(const Projected& s, int i, int j, std::int64_t u, std::int64_t v) {
  const std::int64_t du = s.u[j] - s.u[i], dv = s.v[j] - s.v[i];
  const std::int64_t side = du * (v - s.v[i]) - dv * (u - s.u[i]);
  if (side != 0) return side > 0;
  return dv != 0 ? dv < 0 : du > 0;
}

/// \return 1 or -1, the orientation of the face, if the line through (u, v) crosses it; else 0.
int crosses(const Projected& s, std::int64_t u, std::int64_t v) {
  const bool a = is_left(s, 0, 1, u, v), b = is_left(s, 1, 2, u, v), c = is_left(s, 2, 0, u, v);
  return a == b && b == c ? (a ? 1 : -1) : 0;
}

int floor_int(double x) { return static_cast<int>(std::floor(x)); }
int ceil_int(double x) { return static_cast<int>(std::ceil(x)); }

}  // namespace

void snap(Mesh& mesh) {
  for (Point& p : mesh.points)
    for (double& x : p) x = std::round(x * steps) / steps;
}

bool is_closed(const Mesh& mesh) {
  std::vector<std::uint32_t> order(mesh.points.size()), place(mesh.points.size());
  for (std::uint32_t n = 0; n < order.size(); ++n) order[n] = n;
  std::sort(order.begin(), order.end(),
            [&](std::uint32_t a, std::uint32_t b) { return mesh.points[a] < mesh.points[b]; });
  for (std::size_t n = 1; n < order.size(); ++n) {
    place[order[n]] =
        place[order[n - 1]] + (mesh.points[order[n]] == mesh.points[order[n - 1]] ? 0 : 1);
  }
  struct Edge {
    std::uint32_t from, to;
    int way;
  };
  std::vector<Edge> edges;
  for (const auto& t : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t a = place[t[i]], b = place[t[(i + 1) % 3]];
      edges.push_back({std::min(a, b), std::max(a, b), a < b ? 1 : -1});
    }
  }
  std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) {
    return a.from != b.from ? a.from < b.from : a.to < b.to;
  });
  for (std::size_t i = 0; i < edges.size();) {
    const Edge edge = edges[i];
    int ways = 0;
    for (; i < edges.size() && edges[i].from == edge.from && edges[i].to == edge.to; ++i)
      ways += edges[i].way;
    if (ways != 0 && edge.from != edge.to) return false;
  }
  return true;
}

double area(const Mesh& mesh) {
  double sum = 0;
  for (const auto& t : mesh.triangles) sum += 0.5 * length(normal(mesh, t));
  return sum;
}

// ---- Crossings

Crossings::Crossings(const Mesh& mesh, int axis) {
  const auto w = static_cast<std::size_t>(axis), u = (w + 1) % 3, v = (w + 2) % 3;
  double low[2] = {1e300, 1e300}, high[2] = {-1e300, -1e300};
  for (const Point& p : mesh.points) {
    low[0] = std::min(low[0], p[u]), high[0] = std::max(high[0], p[u]);
    low[1] = std::min(low[1], p[v]), high[1] = std::max(high[1], p[v]);
  }
  for (std::size_t a = 0; a < 2; ++a) {
    low_[a] = ceil_int(low[a]);
    size_[a] = std::max(floor_int(high[a]) - low_[a] + 1, 0);
  }
  const std::size_t lines = static_cast<std::size_t>(size_[0]) * static_cast<std::size_t>(size_[1]);
  first_.assign(lines + 1, 0);

  // Called twice: to count the crossings, and to store them.
  const auto for_crossings = [&](const auto& visit) {
    for (const auto& t : mesh.triangles) {
      const Point n = normal(mesh, t);
      if (n[w] == 0) continue;
      const Point &a = mesh.points[t[0]], &b = mesh.points[t[1]], &c = mesh.points[t[2]];
      const Point* corners[3] = {&a, &b, &c};
      Projected face;
      for (int i = 0; i < 3; ++i) {
        face.u[i] = std::llround((*corners[i])[u] * steps);
        face.v[i] = std::llround((*corners[i])[v] * steps);
      }
      const double along_u[3] = {a[u], b[u], c[u]};
      const int first = ceil_int(*std::min_element(along_u, along_u + 3)),
                last = floor_int(*std::max_element(along_u, along_u + 3));
      for (int i = first; i <= last; ++i) {
        // The range of the face along v at this u.
        double least = 1e300, most = -1e300;
        for (int e = 0; e < 3; ++e) {
          const Point &p = *corners[e], &q = *corners[(e + 1) % 3];
          if ((p[u] < i && q[u] < i) || (p[u] > i && q[u] > i)) continue;
          const double fraction = p[u] == q[u] ? 0 : (i - p[u]) / (q[u] - p[u]);
          const double at = p[v] + fraction * (q[v] - p[v]);
          least = std::min({least, at, p[u] == q[u] ? q[v] : at});
          most = std::max({most, at, p[u] == q[u] ? q[v] : at});
        }
        if (least > most) continue;
        for (int j = ceil_int(least - 1e-9); j <= floor_int(most + 1e-9); ++j) {
          const std::int64_t whole = static_cast<std::int64_t>(steps);
          const int turn = crosses(face, i * whole, j * whole);
          if (turn == 0) continue;
          if (i < low_[0] || i >= low_[0] + size_[0] || j < low_[1] || j >= low_[1] + size_[1])
            continue;
          const std::size_t line =
              static_cast<std::size_t>(i - low_[0]) * static_cast<std::size_t>(size_[1])
              + static_cast<std::size_t>(j - low_[1]);
          const double at = a[w] - (n[u] * (i - a[u]) + n[v] * (j - a[v])) / n[w];
          visit(line, at, n, turn);
        }
      }
    }
  };
  for_crossings([&](std::size_t line, double, const Point&, int) { ++first_[line + 1]; });
  for (std::size_t line = 0; line < lines; ++line) first_[line + 1] += first_[line];
  all_.resize(first_[lines]);
  std::vector<std::uint64_t> next(first_.begin(), first_.end() - 1);
  for_crossings([&](std::size_t line, double at, const Point& n, int turn) {
    const double size = length(n);
    const auto along = [&](std::size_t a) { return static_cast<float>(n[a] / size); };
    all_[next[line]++] = {static_cast<float>(at), {along(w), along(u), along(v)}, turn};
  });
  for (std::size_t line = 0; line < lines; ++line)
    std::stable_sort(all_.begin() + static_cast<std::ptrdiff_t>(first_[line]),
                     all_.begin() + static_cast<std::ptrdiff_t>(first_[line + 1]),
                     [](const Crossing& a, const Crossing& b) { return a.at < b.at; });
}

bool Crossings::is_inside(int u, int v, int along) const {
  const int i = u - low_[0], j = v - low_[1];
  if (i < 0 || j < 0 || i >= size_[0] || j >= size_[1]) return false;
  const std::size_t line = static_cast<std::size_t>(i) * static_cast<std::size_t>(size_[1])
                           + static_cast<std::size_t>(j);
  int winding = 0;
  for (std::uint64_t n = first_[line + 1]; n > first_[line]; --n) {
    const Crossing& c = all_[n - 1];
    if (c.at <= static_cast<float>(along)) break;
    winding += c.to;
  }
  return winding != 0;
}

// ---- Walls

ThinWalls thin_walls(const Crossings& x, const Crossings& y, const Crossings& z) {
  using Crossing = Crossings::Crossing;
  constexpr double thinnest_kept = 1.5;
  constexpr float opposite = -0.7f;  // largest cosine between the normals of a wall's two faces
  constexpr int bins = 64;
  double faces = 0, thin = 0, of_width[bins] = {};
  // The face area per crossing, or 0 if the normal is nearer to another axis: so the lines of the
  // three axes together count each face once.
  const auto area_of = [](const Crossing& c) {
    const float along = std::abs(c.normal[0]);
    const bool is_steep = along >= std::abs(c.normal[1]) && along >= std::abs(c.normal[2]);
    return is_steep ? 1 / double{along} : 0.0;
  };
  const auto is_wall = [](const Crossing& a, const Crossing& b) {
    return a.normal[0] * b.normal[0] + a.normal[1] * b.normal[1] + a.normal[2] * b.normal[2]
           < opposite;
  };
  for (const Crossings* axis : {&x, &y, &z}) {
    axis->for_lines([&](const Crossing* first, const Crossing* last) {
      const Crossing* entry = nullptr;
      int winding = 0;
      for (const Crossing* c = first; c != last; ++c) {
        faces += area_of(*c);
        const bool was_inside = winding != 0;
        winding -= c->to;
        if (!was_inside && winding != 0) entry = c;
        if (!was_inside || winding != 0 || !is_wall(*entry, *c)) continue;
        const double width = double{c->at - entry->at} * std::abs(double{c->normal[0]});
        if (width >= thinnest_kept) continue;
        const double area = area_of(*entry) + area_of(*c);
        thin += area;
        of_width[std::min(static_cast<int>(width / thinnest_kept * bins), bins - 1)] += area;
      }
    });
  }
  ThinWalls walls;
  if (!(thin > 0)) return walls;
  walls.fraction = thin / faces;
  double below = 0;
  int bin = 0;
  while (bin + 1 < bins && (below += of_width[bin]) < 0.05 * thin) ++bin;
  walls.width = (bin + 0.5) * thinnest_kept / bins;
  return walls;
}

// ---- Fractions of voxels

namespace {

/// A convex part of a face. A triangle clipped by the four sides of a column has up to 7 corners;
/// two cuts along the column add one each.
struct Part {
  Point corner[10];
  int count = 0;
};

/// \return the portion of `part` above `bound` along `axis` (below it for side -1).
Part cut(const Part& part, std::size_t axis, double bound, double side) {
  Part kept;
  for (int i = 0; i < part.count; ++i) {
    const Point &a = part.corner[i], &b = part.corner[(i + 1) % part.count];
    const double da = side * (a[axis] - bound), db = side * (b[axis] - bound);
    if (da >= 0) kept.corner[kept.count++] = a;
    if ((da > 0 && db < 0) || (da < 0 && db > 0)) {
      const double fraction = da / (da - db);
      Point p;
      for (std::size_t c = 0; c < 3; ++c) p[c] = a[c] + fraction * (b[c] - a[c]);
      p[axis] = bound;
      kept.corner[kept.count++] = p;
    }
  }
  return kept;
}

/// \return the integral of max(z - bound, 0) over the projection of the part along z, with the sign
/// of the projection's orientation.
double volume_above(const Part& part, double bound) {
  const Part top = cut(part, 2, bound, 1);
  double sum = 0;
  for (int i = 1; i + 1 < top.count; ++i) {
    const Point &a = top.corner[0], &b = top.corner[i], &c = top.corner[i + 1];
    const double twice = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    sum += 0.5 * twice * ((a[2] + b[2] + c[2]) / 3 - bound);
  }
  return sum;
}
double projected_area(const Part& part) {
  double sum = 0;
  for (int i = 1; i + 1 < part.count; ++i) {
    const Point &a = part.corner[0], &b = part.corner[i], &c = part.corner[i + 1];
    sum += 0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]));
  }
  return sum;
}

std::array<double, 2> range(const Part& part, std::size_t axis) {
  double low = 1e300, high = -1e300;
  for (int i = 0; i < part.count; ++i)
    low = std::min(low, part.corner[i][axis]), high = std::max(high, part.corner[i][axis]);
  return {low, high};
}

/// Contributions of a face to the mean winding number: of voxel z of a column, which the face
/// intersects, and of all voxels below z.
struct Piece {
  int y, z;
  double here, below;
};

}  // namespace

void for_cut_voxels(const Mesh& mesh,
                    const std::function<void(int x, int y, int z, double fraction)>& set) {
  // One slice of voxels across x at a time, from the faces that intersect it, to bound the memory
  // for pieces.
  struct Reach {
    int first, last;
    std::uint32_t triangle;
  };
  std::vector<Reach> faces;
  faces.reserve(mesh.triangles.size());
  for (std::uint32_t n = 0; n < mesh.triangles.size(); ++n) {
    const auto& t = mesh.triangles[n];
    const double x[3] = {mesh.points[t[0]][0], mesh.points[t[1]][0], mesh.points[t[2]][0]};
    faces.push_back({floor_int(*std::min_element(x, x + 3) + 0.5),
                     floor_int(*std::max_element(x, x + 3) + 0.5), n});
  }
  std::stable_sort(faces.begin(), faces.end(),
                   [](const Reach& a, const Reach& b) { return a.first < b.first; });
  if (faces.empty()) return;

  std::vector<Reach> active;
  std::vector<Piece> pieces;
  std::size_t next = 0;
  for (int x = faces.front().first; next < faces.size() || !active.empty(); ++x) {
    while (next < faces.size() && faces[next].first <= x) active.push_back(faces[next++]);
    pieces.clear();
    for (const Reach& face : active) {
      const auto& t = mesh.triangles[face.triangle];
      Part whole;
      for (std::size_t i = 0; i < 3; ++i) whole.corner[whole.count++] = mesh.points[t[i]];
      const Part slice = cut(cut(whole, 0, x - 0.5, 1), 0, x + 0.5, -1);
      if (slice.count == 0) continue;
      const auto [y_low, y_high] = range(slice, 1);
      for (int y = floor_int(y_low + 0.5); y <= floor_int(y_high + 0.5); ++y) {
        const Part part = cut(cut(slice, 1, y - 0.5, 1), 1, y + 0.5, -1);
        if (part.count == 0) continue;
        const auto [z_low, z_high] = range(part, 2);
        const double all = projected_area(part);
        const int top = floor_int(z_high + 0.5);
        double above = 0;  // the integral above the voxel's upper side
        for (int z = top; z >= floor_int(z_low + 0.5); --z) {
          const double from_bottom = volume_above(part, z - 0.5);
          pieces.push_back({y, z, from_bottom - above, 0});
          above = from_bottom;
        }
        pieces.push_back({y, floor_int(z_low + 0.5), 0, all});
      }
    }
    std::stable_sort(pieces.begin(), pieces.end(), [](const Piece& a, const Piece& b) {
      return a.y != b.y ? a.y < b.y : a.z > b.z;
    });
    for (std::size_t i = 0; i < pieces.size();) {
      const int y = pieces[i].y;
      double from_above = 0;
      while (i < pieces.size() && pieces[i].y == y) {
        const int z = pieces[i].z;
        double here = from_above;
        for (; i < pieces.size() && pieces[i].y == y && pieces[i].z == z; ++i)
          here += pieces[i].here, from_above += pieces[i].below;
        set(x, y, z, std::min(std::abs(here), 1.0));
      }
    }
    active.erase(std::remove_if(active.begin(), active.end(),
                                [&](const Reach& face) { return face.last <= x; }),
                 active.end());
  }
}

}  // namespace tyndall::io
