/// \file
/// The walk of a photon from one collision to the next: delta tracking, which samples free paths
/// with only bounds of the extinction [SzirmayKalos2011]. Virtual particles fill each super-voxel
/// up to its majorant. The total extinction is then constant there, and a 3-D DDA
/// [AmanatidesWoo1987] finds the free path. A tentative collision is real with probability
/// sigma_t / sigma_maj, otherwise null [Woodcock1965].
#pragma once

#include "tyndall/medium/medium.h"
#include "tyndall/random/random.h"
#include "tyndall/transport/ledger.h"

namespace tyndall {

struct Ray {
  Vec3f origin;
  Vec3f direction;  ///< unit length, the way the photon (or the camera's ray) travels
};

/// The most super-voxels that one flight crosses. With periodic sides and little extinction it
/// might never end otherwise.
inline constexpr int most_crossings = 1 << 20;
/// The most null collisions of one flight. Where the majorant is far above the extinction, and
/// tau / sigma_maj is below the rounding of the distance, the flight would make no progress.
inline constexpr int most_virtual = 1 << 22;

/// \return the distance along a ray to the plane `axis = plane`; largest_float for rays parallel to
/// the plane.
TYN_HD float distance_to_plane(float plane, float origin, float inverse_direction) {
  return inverse_direction == 0.0f ? largest_float : (plane - origin) * inverse_direction;
}

/// 1/d, or 0 where d is 0 or so small that 1/d overflows: the ray never reaches a plane.
TYN_HD float inverse_component(float d) { return abs(d) < 1e-30f ? 0.0f : inverse(d); }

/// The DDA over the super-voxels along a ray. [t, t_exit] is the interval of the ray within the
/// current one. Crossings are computed from the planes, never accumulated. Ties go x, y, z.
class SuperVoxelWalk {
 public:
  TYN_HD SuperVoxelWalk(const MajorantGrid& grid, const Ray& ray) : grid_(grid), ray_(ray) {
    start();
  }

  TYN_HD std::size_t cell() const { return grid_.index(place_.i, place_.j, place_.k); }
  TYN_HD float length_to_exit() const { return t_exit_ - t_; }  ///< [length]
  TYN_HD Vec3f direction() const { return ray_.direction; }
  TYN_HD Vec3f position() const { return ray_.origin + t_ * ray_.direction; }
  TYN_HD void advance(float distance) { t_ = min(t_ + distance, t_exit_); }

  /// Steps into the next super-voxel. \return false where the ray leaves the box, through face().
  TYN_HD bool cross() { return step() || wrap(); }

  /// Steps as cross() does, but also leaves through periodic sides. No branches: lanes step in
  /// lockstep.
  TYN_HD bool step() {
    t_ = t_exit_;
    const bool x = (t_x_ <= t_y_) & (t_x_ <= t_z_), y = !x & (t_y_ <= t_z_), z = !x & !y;
    const int to_x = ray_.direction.x < 0.0f ? -1 : 1, to_y = ray_.direction.y < 0.0f ? -1 : 1,
              to_z = ray_.direction.z < 0.0f ? -1 : 1;
    place_.i += x ? to_x : 0;
    place_.j += y ? to_y : 0;
    place_.k += z ? to_z : 0;
    find_crossings();
    return is_inside();
  }

  /// Re-enters at the opposite face if the ray has left through a periodic side. The ray restarts
  /// there, because positions computed along one long ray would drift.
  TYN_HD bool wrap() {
    if (!grid_.box.is_periodic(face())) return false;
    before_ = before_ + t_;
    ray_.origin = onto_face(grid_.box, face() ^ 1, position());
    start();
    return true;
  }

  TYN_HD bool is_inside() const {
    const bool x = is_below(place_.i, grid_.nx), y = is_below(place_.j, grid_.ny),
               z = is_below(place_.k, grid_.nz);
    return x & y & z;
  }
  /// The face through which the ray has left the box. No branches, as in step().
  TYN_HD Face face() const {
    const bool x = (place_.i < 0) | (place_.i >= grid_.nx);
    const bool y = (place_.j < 0) | (place_.j >= grid_.ny);
    const int at = x ? place_.i : y ? place_.j : place_.k;
    const int low = x ? 0 : y ? 2 : 4;
    return at < 0 ? low : low + 1;
  }

  using Place = Cells::Place;
  TYN_HD Place place() const { return place_; }  ///< the current super-voxel
  TYN_HD float distance() const {
    return t_;
  }                                                ///< along the ray, from the last periodic side
                                                   ///< [length]
  TYN_HD float before() const { return before_; }  ///< up to the last periodic side [length]
  TYN_HD float travelled() const { return before_ + t_; }
  TYN_HD const Ray& ray() const { return ray_; }  ///< from the last periodic side

  /// Resumes a walk along `ray` in super-voxel `place`, at `distance` from the ray's origin.
  TYN_HD SuperVoxelWalk(const MajorantGrid& grid, const Ray& ray, Place place, float distance,
                        float before = 0.0f)
      : grid_(grid), ray_(ray), place_(place), before_(before), t_(distance) {
    invert();
    find_crossings();
  }

  /// Starts another walk in the same grid.
  TYN_HD void start(const Ray& ray) {
    ray_ = ray;
    before_ = 0.0f;
    start();
  }

 private:
  /// Whether 0 <= i < n.
  TYN_HD static bool is_below(int i, int n) {
    return static_cast<std::uint32_t>(i) < static_cast<std::uint32_t>(n);
  }

  TYN_HD void invert() {
    inverse_ = {inverse_component(ray_.direction.x), inverse_component(ray_.direction.y),
                inverse_component(ray_.direction.z)};
  }

  TYN_HD void start() {
    invert();
    place_ = grid_.place_of(ray_.origin);
    t_ = 0.0f;
    find_crossings();
  }

  // Rounding may put a start or a crossing an ulp past the plane; t_ must never decrease.
  TYN_HD void find_crossings() {
    const Vec3f d = ray_.direction, o = ray_.origin;
    t_x_ = crossing(place_.i, grid_.cell_size.x, d.x, o.x, inverse_.x);
    t_y_ = crossing(place_.j, grid_.cell_size.y, d.y, o.y, inverse_.y);
    t_z_ = crossing(place_.k, grid_.cell_size.z, d.z, o.z, inverse_.z);
    t_exit_ = max(t_, min(t_x_, min(t_y_, t_z_)));
  }

  TYN_HD static float crossing(int i, float size, float direction, float origin, float inverse) {
    const float plane = static_cast<float>(direction < 0.0f ? i : i + 1) * size;
    return distance_to_plane(plane, origin, inverse);
  }

  const MajorantGrid& grid_;
  Ray ray_;
  Vec3f inverse_;
  Place place_;
  float before_ = 0.0f, t_, t_x_, t_y_, t_z_, t_exit_;
};

/// The state of a photon or camera path: its ray, its last random numbers, and its event counter.
struct Path {
  Ray ray;
  float tau;            ///< optical depth to go [-]
  std::uint32_t event;  ///< tentative collisions and reflections of the whole path so far
  RandomBlock drawn;    ///< of the last event: accept, tau of the next flight, two for a direction
  float reach = largest_float;  ///< [length] where the flight ends: the light, for a shadow ray

  /// Draws random numbers for a tentative collision or a reflection, and tau of the next flight.
  TYN_HD void draw(const RandomStream& random) {
    drawn = random.block(++event, Purpose::walk);
    tau = exponential(drawn.b);
  }
};

/// Whether a squeezed decision is audited: one in 256, by bits of the block's last word that
/// nothing else uses.
TYN_HD bool is_audited(std::uint32_t last_word) { return (last_word & 0xffu) == 0u; }

struct Flight {
  enum class End { collided, escaped, stalled };

  End end = End::stalled;  ///< escaped: no real collision up to the end of the box or the reach
  int component = virtual_particle;  ///< collided: with this component
  Face face = 0;                     ///< escaped: through this face of the box
  float length = 0;                  ///< [length] of the flight
};

/// Delta tracking of one flight, event by event. tau is carried across cells. After a null
/// collision the flight continues from there.
class Tracker {
 public:
  enum class Event { crossed, within, ended };

  TYN_HD Tracker(const MajorantGrid& grid, const Ray& ray) : grid_(grid), walk_(grid, ray) {}

  /// Crosses into the next super-voxel, unless the tentative collision is in this one. A
  /// super-voxel of majorant 0 needs no branch: tau > 0 always.
  TYN_HD Event cross(Path& path) {
    const float depth = grid_.total[walk_.cell()] * walk_.length_to_exit();
    if (!(path.tau > depth)) return Event::within;
    path.tau = path.tau - depth;
    if (crossings_ == most_crossings || !walk_.step()) return Event::ended;
    ++crossings_;
    return is_beyond_reach(path) ? Event::ended : Event::crossed;
  }

  /// After Event::ended. \return whether the flight continues through a periodic side.
  TYN_HD bool wrap(const Path& path) {
    if (walk_.is_inside() || !walk_.wrap()) return false;
    ++crossings_;
    return !is_beyond_reach(path);
  }

  /// Advances to the tentative collision, after Event::within. \return whether it is within reach.
  TYN_HD bool arrive(const Path& path) {
    walk_.advance(divide(path.tau, grid_.total[walk_.cell()]));
    return !is_beyond_reach(path);
  }

  /// Draws random numbers for a tentative collision. \return the value that the extinction there
  /// must exceed for a real collision [1/length]
  TYN_HD float draw(Path& path, const RandomStream& random) const {
    path.draw(random);
    return uniform(path.drawn.a) * grid_.total[walk_.cell()];
  }

  /// Ends a tentative collision. \param hit the component of a real one, or virtual_particle
  /// \return whether the flight ends
  TYN_HD bool meet(int hit) {
    hit_ = hit;
    return hit != virtual_particle || ++virtual_particles_ == most_virtual;
  }

  /// Ends the flight: moves `path.ray` to its end. \return the flight.
  TYN_HD Flight land(Path& path) const {
    path.ray = {walk_.position(), walk_.direction()};
    Flight flight;
    flight.length = walk_.travelled();
    flight.component = hit_;
    if (hit_ != virtual_particle) {
      flight.end = Flight::End::collided;
    } else if (!walk_.is_inside()) {
      flight.end = Flight::End::escaped;
      flight.face = walk_.face();
    } else if (is_beyond_reach(path)) {
      flight.end = Flight::End::escaped;
    }
    return flight;
  }

  TYN_HD std::size_t cell() const { return walk_.cell(); }
  TYN_HD Vec3f position() const { return walk_.position(); }
  TYN_HD int cells() const { return crossings_ + 1; }

  /// Starts another flight in the same grid.
  TYN_HD void start(const Ray& ray) {
    walk_.start(ray);
    crossings_ = virtual_particles_ = 0;
    hit_ = virtual_particle;
  }

  /// The state from which the flight can be resumed.
  struct Saved {
    Ray ray;
    SuperVoxelWalk::Place place;
    float distance, before;
    int crossings, virtual_particles, hit;
  };
  TYN_HD Saved save() const {
    return {walk_.ray(),        walk_.place(), walk_.distance(), walk_.before(), crossings_,
            virtual_particles_, hit_};
  }
  TYN_HD Tracker(const MajorantGrid& grid, const Saved& s)
      : grid_(grid),
        walk_(grid, s.ray, s.place, s.distance, s.before),
        crossings_(s.crossings),
        virtual_particles_(s.virtual_particles),
        hit_(s.hit) {}

 private:
  TYN_HD bool is_beyond_reach(const Path& path) const { return walk_.travelled() > path.reach; }

  const MajorantGrid& grid_;
  SuperVoxelWalk walk_;
  int crossings_ = 0, virtual_particles_ = 0;
  int hit_ = virtual_particle;
};

/// Runs a flight in one flat loop over its events. Moves `path.ray.origin` to the flight's end.
template <Decision usual = Decision::squeezed, class Medium>
TYN_HD Flight track(const Medium& medium, const MajorantGrid& grid, Path& path,
                    const RandomStream& random, Audit& audit) {
  ++audit.flights;
  Tracker tracker(grid, path.ray);
  Lookups lookups;
  for (;;) {
    const Tracker::Event event = tracker.cross(path);
    if (event == Tracker::Event::crossed) continue;
    if (event == Tracker::Event::ended && tracker.wrap(path)) continue;
    if (event == Tracker::Event::ended || !tracker.arrive(path)) break;
    ++audit.tentative;
    const float v = tracker.draw(path, random);
    const int hit = medium.collide(
        grid, tracker.cell(), v, tracker.position(), lookups,
        usual == Decision::squeezed && is_audited(path.drawn.d) ? Decision::audited : usual);
    if (hit != virtual_particle) ++audit.real;
    if (tracker.meet(hit)) break;
  }
  audit.cells += tracker.cells();
  audit.lookups += lookups.lookups;
  audit.octaves += lookups.octaves;
  audit.violations += lookups.violations;
  return tracker.land(path);
}

/// Delta tracking through the super-voxel grid. The three samplers share one interface, so that a
/// benchmark swaps nothing else.
struct SuperVoxel {
  template <class Medium>
  TYN_HD Flight fly(const Medium& medium, Path& path, const RandomStream& random,
                    Audit& audit) const {
    return track(medium, grid(medium), path, random, audit);
  }
  template <class Medium>
  TYN_HD const MajorantGrid& grid(const Medium& medium) const {
    return medium.super_voxels;
  }
};

/// Delta tracking with one majorant for the whole box [Woodcock1965].
struct Woodcock {
  template <class Medium>
  TYN_HD Flight fly(const Medium& medium, Path& path, const RandomStream& random,
                    Audit& audit) const {
    return track(medium, grid(medium), path, random, audit);
  }
  template <class Medium>
  TYN_HD const MajorantGrid& grid(const Medium& medium) const {
    return medium.whole;
  }
};

/// Ray marching of one flight in fixed steps. The extinction at the middle of a step is used for
/// the whole step. This is biased, and its cost grows with the resolution. The last step is solved
/// linearly.
class March {
 public:
  TYN_HD March(const MajorantGrid& whole, const Ray& ray) : walk_(whole, ray) {}

  /// \param length of a step \return whether the flight continues.
  template <class Medium>
  TYN_HD_INLINED bool step(float length, const Medium& medium, Path& path,
                           const RandomStream& random, TreeNodes& nodes, Audit& audit) {
    if (walk_.travelled() > path.reach) return escape();
    const float stretch = min(length, walk_.length_to_exit());
    const Vec3f middle = walk_.position() + 0.5f * stretch * walk_.direction();
    const float sigma_t = total_sigma_t(medium, middle, nodes);
    for (int i = 0; i < medium.count(); ++i) audit.octaves += medium.component(i).octaves();
    audit.lookups += medium.count();
    const float depth = sigma_t * stretch;
    if (path.tau > depth) {
      path.tau = path.tau - depth;
      if (stretch < length) return cross();  // the step ended at a face
      walk_.advance(stretch);
      return true;
    }
    walk_.advance(path.tau / sigma_t);
    if (walk_.travelled() > path.reach) return escape();
    ++audit.tentative;
    ++audit.real;
    path.draw(random);
    flight_.end = Flight::End::collided;
    flight_.component = choose(medium, middle, uniform(path.drawn.a) * sigma_t, nodes);
    return false;
  }

  /// Ends the flight after its last step: moves `path.ray` to its end. \return the flight.
  TYN_HD Flight land(Path& path) const {
    path.ray = {walk_.position(), walk_.direction()};
    Flight flight = flight_;
    flight.length = walk_.travelled();
    return flight;
  }

  TYN_HD int cells() const { return crossings_ + 1; }

  /// Starts another flight.
  TYN_HD void start(const Ray& ray) {
    walk_.start(ray);
    crossings_ = 0;
    flight_ = {};
  }

  /// The state from which the flight can be resumed between two steps.
  struct Saved {
    Ray ray;
    SuperVoxelWalk::Place place;
    float distance, before;
    int crossings;
  };
  TYN_HD Saved save() const {
    return {walk_.ray(), walk_.place(), walk_.distance(), walk_.before(), crossings_};
  }
  TYN_HD March(const MajorantGrid& whole, const Saved& s)
      : walk_(whole, s.ray, s.place, s.distance, s.before), crossings_(s.crossings) {}

 private:
  TYN_HD bool escape() {
    flight_.end = Flight::End::escaped;
    return false;
  }
  TYN_HD bool cross() {
    if (crossings_ == most_crossings) return false;  // stalled
    if (walk_.cross()) {
      ++crossings_;
      return true;
    }
    flight_.face = walk_.face();
    return escape();
  }

  template <class Medium>
  TYN_HD static int choose(const Medium& medium, Vec3f p, float v, TreeNodes& nodes) {
    for (int i = 0; i + 1 < medium.count(); ++i) {
      v = v - medium.component(i).sigma_t(p, nodes);
      if (v < 0.0f) return i;
    }
    return medium.count() - 1;
  }

  SuperVoxelWalk walk_;
  int crossings_ = 0;
  Flight flight_;
};

struct RayMarching {
  float step;  ///< [length], by default of the finest voxel

  template <class Medium>
  TYN_HD_APART Flight fly(const Medium& medium, Path& path, const RandomStream& random,
                          Audit& audit) const {
    ++audit.flights;
    March march(medium.whole, path.ray);
    TreeNodes nodes;
    while (march.step(step, medium, path, random, nodes, audit)) {
    }
    audit.cells += march.cells();
    return march.land(path);
  }
};

/// Whether a ray enters the medium.
enum class Entry { open, ground, none };

/// Moves the origin of `ray` to where it enters the medium: onto the box if it starts outside (only
/// open sides bound it), and into the first period along periodic axes. \return none if the ray
/// misses the medium, ground if it ends at the back of a ground. \param[out] distance to the new
/// origin [length]
TYN_HD Entry approach(const Box& box, Ray& ray, float& distance) {
  float t0 = 0.0f, t1 = largest_float;
  Face face = -1;  // hit at t0, if the ray starts outside
  const auto slab = [&](int axis, float origin, float direction, float extent) {
    const float inverse = inverse_component(direction);
    if (inverse == 0.0f) {
      if (origin < 0.0f || origin > extent) t1 = -1.0f;
    } else {
      const float a = (0.0f - origin) * inverse, b = (extent - origin) * inverse;
      if (min(a, b) > t0) face = 2 * axis + (direction < 0.0f ? 1 : 0);
      t0 = max(t0, min(a, b));
      t1 = min(t1, max(a, b));
    }
  };
  if (!box.periodic_x) slab(0, ray.origin.x, ray.direction.x, box.extent.x);
  if (!box.periodic_y) slab(1, ray.origin.y, ray.direction.y, box.extent.y);
  if (!box.periodic_z) slab(2, ray.origin.z, ray.direction.z, box.extent.z);
  if (t0 > t1) return Entry::none;
  const auto inside = [](float x, float extent, bool periodic) {
    if (periodic) x = x - extent * floor(x / extent);
    return clamp(x, 0.0f, extent);
  };
  const Vec3f p = ray.origin + t0 * ray.direction;
  ray.origin = {inside(p.x, box.extent.x, box.periodic_x),
                inside(p.y, box.extent.y, box.periodic_y),
                inside(p.z, box.extent.z, box.periodic_z)};
  distance = t0;
  return face >= 0 && box.is_ground(face) ? Entry::ground : Entry::open;
}
TYN_HD Entry approach(const Box& box, Ray& ray) {
  float distance;
  return approach(box, ray, distance);
}
TYN_HD bool enter(const Box& box, Ray& ray) { return approach(box, ray) == Entry::open; }

}  // namespace tyndall
