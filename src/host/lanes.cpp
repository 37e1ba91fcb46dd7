#include "host/lanes.h"

#include <memory>

#include "host/lane_stages.h"

namespace tyndall {

#define TYNDALL_DECLARE_STAGES(isa) \
  namespace isa {                   \
  extern const LaneStages stages;   \
  }
TYNDALL_DECLARE_STAGES(plain)
#if defined(TYNDALL_LANES_X86_64_V4)
TYNDALL_DECLARE_STAGES(v4)
#endif

namespace {

/// The widest that this processor has.
LaneStages lane_stages() {
#if defined(TYNDALL_LANES_X86_64_V4)
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw")
      && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl")
      && __builtin_cpu_supports("avx512cd"))
    return v4::stages;
#endif
  return plain::stages;
}

/// Moves photons between the stages, and keeps their account.
class Batch {
 public:
  using Pass = ShootPass<SingleMedium<NoiseCloud>, SuperVoxel>;

  explicit Batch(const Pass& pass) : pass_(pass), grid_(pass.medium.super_voxels) {
    for (int l = 0; l < Lanes::size; ++l) {
      lanes_.state[l] = Lanes::idle;
      lanes_.cell[l] = 0;
    }
  }

  void shoot(std::uint64_t begin, std::uint64_t end, const Stop& stop) {
    const LaneStages stages = lane_stages();
    const Component<NoiseCloud>& component = pass_.medium.single;
    next_ = begin, end_ = end;
    while (refill() > 0) {
      stop_if(stop);
      audit_.cells += stages.walk(lanes_, grid_, turns);
      stages.draw(lanes_, grid_, pass_.seed);
      pack();
      audit_.octaves += stages.decide(some_, lanes_, component);
      if (component.scatters()) stages.locate(lanes_, pass_.illumination.cells);
      collide();
      stages.scatter(lanes_, grid_, component.phase);
    }
    deposit_audit(pass_.account->audit, audit_);
  }

 private:
  // More would leave more lanes waiting for the last, fewer would draw for lanes that did not
  // arrive.
  static constexpr int turns = 3;

  /// Lanes whose photon left or ended get the next ones. \return how many are under way.
  int refill() {
    int under_way = 0;
    for (int l = 0; l < lanes_.used; ++l) {
      if (lanes_.state[l] == Lanes::left) leave(l, Flight::End::escaped);
      while (lanes_.state[l] == Lanes::idle && next_ < end_) emit_into(l, next_++);
      under_way += lanes_.state[l] != Lanes::idle;
    }
    if (next_ == end_ && 2 * under_way <= lanes_.used) close_ranks(under_way);
    return under_way;
  }

  /// The last photons move together: a few that scatter for long would keep all lanes busy.
  void close_ranks(int under_way) {
    int to = 0;
    for (int from = 0; from < lanes_.used; ++from) {
      if (lanes_.state[from] == Lanes::idle) continue;
      if (to != from) move(from, to);
      ++to;
    }
    constexpr int widest = 16;
    lanes_.used = (under_way + widest - 1) / widest * widest;
  }

  void move(int from, int to) {
    const auto each = [&](auto&... arrays) { ((arrays[to] = arrays[from]), ...); };
    each(lanes_.index, lanes_.event, lanes_.weight_x, lanes_.weight_y, lanes_.weight_z,
         lanes_.state, lanes_.origin_x, lanes_.origin_y, lanes_.origin_z, lanes_.direction_x,
         lanes_.direction_y, lanes_.direction_z, lanes_.tau, lanes_.distance,
         lanes_.virtual_particles, lanes_.i, lanes_.j, lanes_.k, lanes_.face, lanes_.cell);
    lanes_.state[from] = Lanes::idle;
  }

  void emit_into(int l, std::uint64_t index) {
    Path path;
    Vec3f w;
    if (!pass_.begin({pass_.seed, index, Domain::photon}, path, w)) return;
    lanes_.index[l] = index;
    lanes_.event[l] = path.event;
    lanes_.tau[l] = path.tau;
    set_weight(l, w);
    lanes_.direction_x[l] = path.ray.direction.x;
    lanes_.direction_y[l] = path.ray.direction.y;
    lanes_.direction_z[l] = path.ray.direction.z;
    const Vec3f o = path.ray.origin;
    lanes_.origin_x[l] = o.x;
    lanes_.origin_y[l] = o.y;
    lanes_.origin_z[l] = o.z;
    lanes_.i[l] = MajorantGrid::coordinate(o.x, grid_.inverse_cell_size.x, grid_.nx);
    lanes_.j[l] = MajorantGrid::coordinate(o.y, grid_.inverse_cell_size.y, grid_.ny);
    lanes_.k[l] = MajorantGrid::coordinate(o.z, grid_.inverse_cell_size.z, grid_.nz);
    lanes_.cell[l] = static_cast<std::int32_t>(grid_.index(lanes_.i[l], lanes_.j[l], lanes_.k[l]));
    lanes_.distance[l] = 0.0f;
    lanes_.state[l] = Lanes::walking;
    begin_flight(l);
  }

  /// Packs what the minorant left undecided; audits some of it by the full density.
  void pack() {
    const Component<NoiseCloud>& component = pass_.medium.single;
    int n = 0;
    for (int l = 0; l < lanes_.used; ++l) {
      audit_.tentative += lanes_.state[l] == Lanes::arrived;
      if (lanes_.real[l] != Lanes::undecided) continue;
      const Vec3f p{lanes_.x[l], lanes_.y[l], lanes_.z[l]};
      const float v = lanes_.v[l];
      ++audit_.lookups;
      if (is_audited(lanes_.word_d[l])) {
        LookupCount count;
        const auto cell = grid_.index(lanes_.i[l], lanes_.j[l], lanes_.k[l]);
        lanes_.real[l] = is_real(grid_, 0, component, cell, v, p, count, Decision::audited);
        audit_.octaves += count.octaves;
        audit_.violations += count.violations;
      } else if (v >= component.extinction) {
        lanes_.real[l] = 0;
      } else {
        some_.x[n] = p.x;
        some_.y[n] = p.y;
        some_.z[n] = p.z;
        some_.v[n] = v;
        some_.lane[n++] = l;
      }
    }
    some_.count = n;
  }

  /// Real collisions: score, absorb, play roulette.
  void collide() {
    const Component<NoiseCloud>& component = pass_.medium.single;
    const bool scatters = component.scatters();
    const auto moments = static_cast<std::size_t>(pass_.illumination.cells.moments());
    if (scatters) {  // asked for early: an atomic addition waits for its memory alone
      for (int l = 0; l < lanes_.used; ++l) {
        const auto cell = static_cast<std::size_t>(lanes_.illumination_cell[l]);
        if (lanes_.real[l] == 1) __builtin_prefetch(pass_.illumination.sums + cell * moments, 1);
      }
    }
    const bool absorbs =
        !(component.albedo.x == 1.0f && component.albedo.y == 1.0f && component.albedo.z == 1.0f);
    for (int l = 0; l < lanes_.used; ++l) {
      if (lanes_.state[l] != Lanes::arrived) continue;
      if (lanes_.real[l] != 1) {
        if (++lanes_.virtual_particles[l] == most_virtual) leave(l, Flight::End::stalled);
        continue;
      }
      ++audit_.real;
      const Vec3f w = weight(l);
      const Vec3f direction{lanes_.direction_x[l], lanes_.direction_y[l], lanes_.direction_z[l]};
      if (scatters)
        pass_.illumination.score(static_cast<std::size_t>(lanes_.illumination_cell[l]), direction,
                                 w);
      if (absorbs) {
        const RandomStream random{pass_.seed, lanes_.index[l], Domain::photon};
        Vec3f after = w;
        if (!pass_.survive(0, component.albedo, random, lanes_.event[l], after)) {
          lanes_.state[l] = Lanes::idle;
          continue;
        }
        set_weight(l, after);
      }
      begin_flight(l);
    }
  }

  /// A box with open sides has fewer super-voxels along a ray than most_crossings: flights stall
  /// among virtual particles alone.
  void leave(int l, Flight::End end) {
    pass_.leave({end, virtual_particle, lanes_.face[l]}, weight(l));
    lanes_.state[l] = Lanes::idle;
  }

  void begin_flight(int l) {
    lanes_.virtual_particles[l] = 0;
    ++audit_.flights;
    ++audit_.cells;
  }

  Vec3f weight(int l) const { return {lanes_.weight_x[l], lanes_.weight_y[l], lanes_.weight_z[l]}; }
  void set_weight(int l, Vec3f w) {
    lanes_.weight_x[l] = w.x;
    lanes_.weight_y[l] = w.y;
    lanes_.weight_z[l] = w.z;
  }

  const Pass& pass_;
  const MajorantGrid& grid_;
  std::uint64_t next_ = 0, end_ = 0;
  Audit audit_;
  Lanes lanes_;
  Undecided some_;
};

}  // namespace

void shoot_lanes(const ShootPass<SingleMedium<NoiseCloud>, SuperVoxel>& pass, std::uint64_t begin,
                 std::uint64_t end, const Stop& stop) {
  std::make_unique<Batch>(pass)->shoot(begin, end, stop);
}

}  // namespace tyndall
