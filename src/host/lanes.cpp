#include "host/lanes.h"

#include <memory>
#include <string_view>

#include "host/lane_stages.h"
#include "host/pack.h"
#include "tyndall/render/render.h"

namespace tyndall {

#define TYNDALL_DECLARE_STAGES(isa) \
  namespace isa {                   \
  extern const LaneStages stages;   \
  }
TYNDALL_DECLARE_STAGES(plain)
#if defined(TYNDALL_LANES_X86_64)
TYNDALL_DECLARE_STAGES(v3)
TYNDALL_DECLARE_STAGES(v4)
#endif

namespace {

/// The stages that this processor can run, the widest first.
std::vector<const LaneStages*> available_stages() {
  std::vector<const LaneStages*> list;
#if defined(TYNDALL_LANES_X86_64)
  if (__builtin_cpu_supports("x86-64-v4")) list.push_back(&v4::stages);
  if (__builtin_cpu_supports("x86-64-v3")) list.push_back(&v3::stages);
#endif
  list.push_back(&plain::stages);
  return list;
}

const LaneStages& stages_named(std::string_view name) {
  static const std::vector<const LaneStages*> list = available_stages();
  for (const LaneStages* stages : list)
    if (stages->name == name) return *stages;
  return *list.front();
}

/// Moves paths between the stages and keeps their account. The Driver begins and ends paths and
/// handles their collisions:
///   uint64_t stream(uint64_t index)             the index of a path's random numbers
///   bool begin(RandomStream, Path&, int lane)   false if the path ends immediately
///   bool leave(int lane, Flight, Path&)         whether it continues, with the flight `path`
///   bool collide(int lane, int component)       false if the path ends
///   void move(int from, int to)                 moves the driver's own data of a lane
template <class Driver, class Medium>
class Batch {
 public:
  Batch(const Medium& medium, std::uint64_t seed, Domain domain, Account* account,
        const LaneStages& stages)
      : medium_(medium),
        grid_(medium.super_voxels),
        seed_(seed),
        domain_(domain),
        account_(account),
        stages_(stages) {}

  void run(std::uint64_t begin, std::uint64_t end, const Stop& stop) {
    next_ = begin, end_ = end;
    while (refill()) {
      stop_if(stop);
      audit_.cells += stages_.walk(lanes_, grid_, turns);
      audit_.tentative += stages_.draw(lanes_, grid_, seed_, domain_);
      for (int c = 0; c < medium_.count(); ++c) decide(c);
      collide();
      stages_.go_on(lanes_, grid_);
    }
    deposit_audit(account_->audit, audit_);
  }

 protected:
  // With more turns, more lanes wait for the last one; with fewer, draw() runs for lanes that did
  // not arrive.
  static constexpr int turns = 3;

  /// Starts the next paths in the lanes whose path ended. \return whether any path is left.
  bool refill() {
    int free = stages_.free(lanes_);
    if (free == 0) return true;
    int idle = 0;
    for (int f = 0; f < free; ++f) {
      const int l = lanes_.listed[f];
      const bool left = lanes_.state[l] == Lanes::left, stalled = lanes_.state[l] == Lanes::stalled;
      lanes_.state[l] = Lanes::idle;
      Path path{{position(l), direction(l)}, 0, lanes_.event[l], {}, lanes_.reach[l]};
      const Flight flight{left ? Flight::End::escaped : Flight::End::stalled, virtual_particle,
                          lanes_.face[l], lanes_.distance[l]};
      if ((left || stalled) && driver().leave(l, flight, path)) set_out(l, path);
      while (lanes_.state[l] == Lanes::idle && next_ < end_) begin(l, driver().stream(next_++));
      idle += lanes_.state[l] == Lanes::idle;
    }
    const int under_way = lanes_.used - idle;
    if (2 * under_way <= lanes_.used) compact(under_way);
    return under_way > 0;
  }

  /// Packs the last paths: otherwise a few long paths would keep all lanes busy.
  void compact(int under_way) {
    int to = 0;
    for (int from = 0; from < lanes_.used; ++from) {
      if (lanes_.state[from] == Lanes::idle) continue;
      if (to != from) move(from, to);
      ++to;
    }
    lanes_.used = whole_registers(under_way);
  }

  void move(int from, int to) {
    const auto each = [&](auto&... arrays) { ((arrays[to] = arrays[from]), ...); };
    driver().move(from, to);
    each(lanes_.index, lanes_.event, lanes_.weight_x, lanes_.weight_y, lanes_.weight_z,
         lanes_.group, lanes_.scores, lanes_.reach, lanes_.state, lanes_.origin_x, lanes_.origin_y,
         lanes_.origin_z, lanes_.direction_x, lanes_.direction_y, lanes_.direction_z, lanes_.tau,
         lanes_.distance, lanes_.virtual_particles, lanes_.i, lanes_.j, lanes_.k, lanes_.face,
         lanes_.cell);
    lanes_.state[from] = Lanes::idle;
  }

  void begin(int l, std::uint64_t index) {
    Path path;
    lanes_.index[l] = index;
    if (driver().begin({seed_, index, domain_}, path, l)) set_out(l, path);
  }

  void set_out(int l, const Path& path) {
    lanes_.event[l] = path.event;
    lanes_.tau[l] = path.tau;
    lanes_.reach[l] = path.reach;
    lanes_.direction_x[l] = path.ray.direction.x;
    lanes_.direction_y[l] = path.ray.direction.y;
    lanes_.direction_z[l] = path.ray.direction.z;
    const Vec3f o = path.ray.origin;
    lanes_.origin_x[l] = o.x;
    lanes_.origin_y[l] = o.y;
    lanes_.origin_z[l] = o.z;
    const Cells::Place at = grid_.place_of(o);
    lanes_.i[l] = at.i;
    lanes_.j[l] = at.j;
    lanes_.k[l] = at.k;
    lanes_.cell[l] = static_cast<std::int32_t>(grid_.index(at.i, at.j, at.k));
    lanes_.distance[l] = 0.0f;
    lanes_.virtual_particles[l] = 0;
    lanes_.state[l] = Lanes::walking;
    count_flight();
  }

  /// Decides the collisions that the minorant of component `c` left undecided.
  void decide(int c) {
    const auto& component = medium_.component(c);
    const int audited = stages_.ask(lanes_, some_, c);
    audit_.lookups += audited + some_.count;
    for (int a = 0; a < audited; ++a) {
      const int l = lanes_.listed[a];
      Lookups lookups;
      const auto cell = static_cast<std::size_t>(lanes_.cell[l]);
      lanes_.real[l] =
          is_real(grid_, c, component, cell, lanes_.v[l], position(l), lookups, Decision::audited);
      audit_.octaves += lookups.octaves;
      audit_.violations += lookups.violations;
    }
    const bool is_squeezed = if_squeezable(component.field, [&](const auto& field) {
      audit_.octaves +=
          stages_.decide(some_, lanes_, field, component.to_field, component.extinction);
    });
    if (is_squeezed) return;
    Lookups lookups;
    for (int m = 0; m < some_.count; ++m) {
      lanes_.real[some_.lane[m]] =
          component.exceeds({some_.x[m], some_.y[m], some_.z[m]}, some_.v[m], lookups);
    }
  }

  void collide() {
    const int real = stages_.collided(lanes_);
    audit_.real += real;
    driver().before(real);
    for (int r = 0; r < real; ++r) {
      const int l = lanes_.listed[r];
      if (driver().collide(l, lanes_.component[l])) {
        count_flight();
      } else {
        lanes_.state[l] = Lanes::idle;
      }
    }
    driver().after();
  }

  /// Replaces a collided flight by a new one, which LaneStages::go_on starts.
  void turn(int l, const Path& path) {
    lanes_.x[l] = path.ray.origin.x;
    lanes_.y[l] = path.ray.origin.y;
    lanes_.z[l] = path.ray.origin.z;
    lanes_.direction_x[l] = path.ray.direction.x;
    lanes_.direction_y[l] = path.ray.direction.y;
    lanes_.direction_z[l] = path.ray.direction.z;
    lanes_.tau[l] = path.tau;
    lanes_.reach[l] = path.reach;
  }

  void count_flight() {
    ++audit_.flights;
    ++audit_.cells;
  }

  Vec3f position(int l) const { return {lanes_.x[l], lanes_.y[l], lanes_.z[l]}; }
  Vec3f direction(int l) const {
    return {lanes_.direction_x[l], lanes_.direction_y[l], lanes_.direction_z[l]};
  }

  Driver& driver() { return static_cast<Driver&>(*this); }

  const Medium& medium_;
  const MajorantGrid& grid_;
  const std::uint64_t seed_;
  const Domain domain_;
  Account* const account_;
  const LaneStages& stages_;
  std::uint64_t next_ = 0, end_ = 0;
  Audit audit_;
  Lanes lanes_{};
  Undecided some_{};
};

/// Photons: scoring, absorption, Russian roulette, scattering.
template <class Medium>
class PhotonBatch : public Batch<PhotonBatch<Medium>, Medium> {
 public:
  using Pass = ShootPass<Medium, SuperVoxel>;
  using Base = Batch<PhotonBatch, Medium>;

  PhotonBatch(const Pass& pass, const LaneStages& stages)
      : Base(pass.medium, pass.seed, Pass::domain, &pass.accounts.own(), stages), pass_(pass) {}

  static std::uint64_t stream(std::uint64_t index) { return index; }
  bool begin(const RandomStream& random, Path& path, int l) {
    Burden burden;
    return pass_.begin(burden, random, path) && carry(l, burden);
  }

  bool leave(int l, const Flight& flight, Path& path) {
    const RandomStream random{pass_.seed, lanes_.index[l], Pass::domain};
    Burden burden = carried(l);
    return pass_.leave(burden, flight, random, path) && carry(l, burden);
  }

  void move(int from, int to) { tracks_[to] = tracks_[from]; }

  // Prefetches the cells: otherwise each atomic addition waits for its memory.
  void before(int real) {
    this->stages_.locate(lanes_, pass_.illumination.cells);
    const auto moments = static_cast<std::size_t>(pass_.illumination.cells.moments());
    const std::int64_t* sums = pass_.illumination.sums;
    for (int r = 0; r < real; ++r) {
      const auto cell = static_cast<std::size_t>(lanes_.illumination_cell[lanes_.listed[r]]);
      __builtin_prefetch(sums + cell * moments, 1);
    }
  }

  bool collide(int l, int c) {
    const RandomStream random{pass_.seed, lanes_.index[l], Pass::domain};
    const Flight flight{Flight::End::collided, c, 0, lanes_.distance[l]};
    const auto cell = [&] { return static_cast<std::size_t>(lanes_.illumination_cell[l]); };
    Burden burden = carried(l);
    return pass_.interact(burden, flight, {this->position(l), this->direction(l)}, random,
                          lanes_.event[l], cell)
           && carry(l, burden);
  }

  void after() {
    for (int c = 0; c < pass_.medium.count(); ++c) {
      const auto& component = pass_.medium.component(c);
      if (component.scatters()) this->stages_.scatter(lanes_, c, component.phase);
    }
  }

 private:
  using Base::lanes_;

  Burden carried(int l) const {
    return {{lanes_.weight_x[l], lanes_.weight_y[l], lanes_.weight_z[l]},
            lanes_.group[l],
            lanes_.scores[l] != 0,
            tracks_[l]};
  }
  bool carry(int l, const Burden& burden) {
    lanes_.weight_x[l] = burden.weight.x;
    lanes_.weight_y[l] = burden.weight.y;
    lanes_.weight_z[l] = burden.weight.z;
    lanes_.group[l] = burden.group;
    lanes_.scores[l] = burden.scores;
    tracks_[l] = burden.track;
    return true;
  }

  const Pass& pass_;
  Track tracks_[Lanes::size];
};

/// Samples of the image.
template <class Medium>
class SampleBatch : public Batch<SampleBatch<Medium>, Medium> {
 public:
  using Pass = GatherPass<Medium, SuperVoxel>;
  using Base = Batch<SampleBatch, Medium>;

  SampleBatch(const Pass& pass, const LaneStages& stages)
      : Base(pass.medium, pass.seed, Pass::domain, &pass.accounts.own(), stages), pass_(pass) {}

  std::uint64_t stream(std::uint64_t index) const { return pass_.stream(index); }
  bool begin(const RandomStream& random, Path& path, int l) {
    return ended_unless(pass_.begin(sights_[l], random, path), l);
  }
  bool leave(int l, const Flight& flight, Path& path) {
    const RandomStream random{pass_.seed, lanes_.index[l], Pass::domain};
    return ended_unless(pass_.leave(sights_[l], flight, random, path), l);
  }
  void before(int) {}
  bool collide(int l, int c) {
    const RandomStream random{pass_.seed, lanes_.index[l], Pass::domain};
    Path path{{this->position(l), this->direction(l)},
              lanes_.tau[l],
              lanes_.event[l],
              {0, 0, lanes_.word_c[l], lanes_.word_d[l]}};
    const Flight flight{Flight::End::collided, c};
    if (!ended_unless(pass_.collide(sights_[l], flight, random, path), l)) return false;
    this->turn(l, path);
    return true;
  }
  void after() {}
  void move(int from, int to) { sights_[to] = sights_[from]; }

 private:
  using Base::lanes_;

  bool ended_unless(bool goes_on, int l) {
    if (!goes_on) pass_.end(sights_[l]);
    return goes_on;
  }

  const Pass& pass_;
  Sight sights_[Lanes::size];
};

/// Integrates the extinction of cells, with the points of a cell in lanes.
template <class Medium>
class MatterBatch {
 public:
  using Pass = MatterPass<Medium>;

  MatterBatch(const Pass& pass, const LaneStages& stages) : pass_(pass), stages_(stages) {}

  void run(std::uint64_t begin, std::uint64_t end, const Stop& stop) {
    for (std::uint64_t cell = begin; cell < end; ++cell) {
      stop_if(stop);
      pass_.matter[cell] =
          pass_.total(cell, [this](std::uint64_t index, int n, std::uint32_t event) {
            typename Pass::Measure all{0, 0};
            for (int m = 0; m < n * n * n; ++m) {
              const Vec3f p = pass_.point(index, n, event, m);
              if (!pass_.may_have_matter(p)) continue;
              points_.x[points_.count] = p.x;
              points_.y[points_.count] = p.y;
              points_.z[points_.count] = p.z;
              if (++points_.count == MatterPoints::size) add_to(all);
            }
            add_to(all);
            return all;
          });
    }
  }

 private:
  void add_to(typename Pass::Measure& all) {
    float sums[MatterPoints::size] = {};
    for (int c = 0; c < pass_.medium.count(); ++c) {
      const auto& component = pass_.medium.component(c);
      if (!component.scatters()) continue;
      const bool is_squeezed = if_squeezable(
          component.field, [&](const auto& field) { add_squeezed(field, component, sums); });
      if (is_squeezed) continue;
      TreeNodes nodes;
      for (int m = 0; m < points_.count; ++m) {
        const float sigma_t = component.sigma_t({points_.x[m], points_.y[m], points_.z[m]}, nodes);
        if (sigma_t > pass_.least()) sums[m] = sums[m] + sigma_t;
      }
    }
    for (int m = 0; m < points_.count; ++m) all.add(pass_.to_units(sums[m]));
    points_.count = 0;
  }

  /// First decides which points lie within the component, which takes few octaves.
  template <Squeezable Field, class Component>
  void add_squeezed(const Field& field, const Component& component, float* sums) {
    some_.count = points_.count;
    for (int m = 0; m < points_.count; ++m) {
      some_.x[m] = lanes_.x[m] = points_.x[m];
      some_.y[m] = lanes_.y[m] = points_.y[m];
      some_.z[m] = lanes_.z[m] = points_.z[m];
      some_.v[m] = lanes_.v[m] = pass_.least();
      some_.lane[m] = m;
      lanes_.real[m] = 0;
    }
    stages_.decide(some_, lanes_, field, component.to_field, component.extinction);
    inside_.count = 0;
    for (int m = 0; m < points_.count; ++m) {
      if (lanes_.real[m] == 0) continue;
      const int n = inside_.count++;
      inside_.x[n] = points_.x[m];
      inside_.y[n] = points_.y[m];
      inside_.z[n] = points_.z[m];
    }
    stages_.extinction(inside_, field, component.to_field, component.extinction);
    int n = 0;
    for (int m = 0; m < points_.count; ++m)
      if (lanes_.real[m] != 0) sums[m] = sums[m] + inside_.sigma_t[n++];
  }

  const Pass& pass_;
  const LaneStages& stages_;
  MatterPoints points_{}, inside_{};
  Lanes lanes_{};
  Undecided some_{};
};

}  // namespace

std::vector<std::string> instruction_sets() {
  std::vector<std::string> names;
  for (const LaneStages* stages : available_stages()) names.emplace_back(stages->name);
  return names;
}

template <class Medium>
void run_lanes(const ShootPass<Medium, SuperVoxel>& pass, std::uint64_t begin, std::uint64_t end,
               const Stop& stop, const std::string& instruction_set) {
  std::make_unique<PhotonBatch<Medium>>(pass, stages_named(instruction_set))->run(begin, end, stop);
}

template <class Medium>
void run_lanes(const GatherPass<Medium, SuperVoxel>& pass, std::uint64_t begin, std::uint64_t end,
               const Stop& stop, const std::string& instruction_set) {
  std::make_unique<SampleBatch<Medium>>(pass, stages_named(instruction_set))->run(begin, end, stop);
}

template <class Medium>
void run_lanes(const MatterPass<Medium>& pass, std::uint64_t begin, std::uint64_t end,
               const Stop& stop, const std::string& instruction_set) {
  std::make_unique<MatterBatch<Medium>>(pass, stages_named(instruction_set))->run(begin, end, stop);
}

#define TYNDALL_INSTANTIATE(Medium)                                                             \
  template void run_lanes(const ShootPass<Medium, SuperVoxel>&, std::uint64_t, std::uint64_t,   \
                          const Stop&, const std::string&);                                     \
  template void run_lanes(const GatherPass<Medium, SuperVoxel>&, std::uint64_t, std::uint64_t,  \
                          const Stop&, const std::string&);                                     \
  template void run_lanes(const MatterPass<Medium>&, std::uint64_t, std::uint64_t, const Stop&, \
                          const std::string&);
#define TYNDALL_INSTANTIATE_SINGLE(Field, name) TYNDALL_INSTANTIATE(SingleMedium<Field>)
TYN_FOR_EACH_FIELD(TYNDALL_INSTANTIATE_SINGLE)
TYNDALL_INSTANTIATE(MixedMedium)

}  // namespace tyndall
