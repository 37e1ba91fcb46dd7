/// \file
/// Lanes that go in lockstep, such as the 32 of a warp: a loop over flights would wait for the
/// longest of them, and a loop over octaves for the hardest decision. So each lane is a machine of
/// its own whose work comes in small pieces, and takes a new path when its own has ended. The
/// pieces are those of the plain loops, follow() and track(), in the same order for each path, so
/// the results are the same, bit for bit.
#pragma once

#include "tyndall/transport/passes.h"

namespace tyndall {

/// What a lane has to do next.
enum class Stage { idle, walk, draw, add_octave, collide, leave };
inline constexpr int stage_count = 6;

/// Whether a pass has paths through a grid of majorants.
template <class Pass>
inline constexpr bool has_lanes = requires(const Pass& pass) {
  pass.sampler.grid(pass.medium);
};

/// One path at a time, of such a pass.
template <class Pass>
class Lane {
 public:
  /// What is kept of a lane between launches. All zero: it is idle.
  struct Saved {
    Stage stage;
    std::uint64_t stream;  ///< whose random numbers the path has
    Path path;
    typename Pass::State state;
    Tracker::Saved tracker;
    // The tentative collision that is being decided:
    int component;
    float v;
    NoiseCloud::Squeeze squeeze;
  };

  TYN_HD Lane(const Pass& pass, const Saved& saved)
      : pass_(pass),
        grid_(pass.sampler.grid(pass.medium)),
        now_(saved),
        tracker_(grid_, saved.tracker) {}

  TYN_HD Saved save() const {
    Saved saved = now_;
    saved.tracker = tracker_.save();
    return saved;
  }

  TYN_HD Stage stage() const { return now_.stage; }

  // The pieces of work. Expect the lane to be at their stage.

  TYN_HD void begin(std::uint64_t index) {
    now_.stream = pass_.stream(index);
    go_on(pass_.begin(now_.state, random(), now_.path));
  }

  TYN_HD void walk() {
    const Tracker::Event event = tracker_.step(now_.path);
    if (event == Tracker::Event::tentative) now_.stage = Stage::draw;
    if (event == Tracker::Event::ended) now_.stage = Stage::leave;
  }

  TYN_HD void draw() {
    ++audit_.tentative;
    now_.v = tracker_.draw(now_.path, random());
    now_.component = pass_.medium.choose(grid_, tracker_.cell(), now_.v);
    if (now_.component == virtual_particle) return meet(false);
    const auto& component = pass_.medium.component(now_.component);
    const NoiseCloud* cloud = noise_cloud(component.field);
    if (!cloud) {
      return meet(is_real(grid_, now_.component, component, tracker_.cell(), now_.v,
                          tracker_.position(), lookups_,
                          is_audited() ? Decision::audited : Decision::squeezed));
    }
    if (now_.v < grid_.lower[bounds()]) return meet(true);
    ++lookups_.lookups;
    now_.squeeze =
        cloud->begin_squeeze(component.to_field(tracker_.position()), component.extinction, now_.v);
    now_.stage = Stage::add_octave;
    decide(*cloud, component.extinction);
  }

  TYN_HD void add_octave() {
    const auto& component = pass_.medium.component(now_.component);
    const NoiseCloud* cloud = noise_cloud(component.field);
    if (!cloud) return;  // no lane of other fields gets here
    ++lookups_.octaves;
    cloud->add_octave(now_.squeeze, component.extinction, now_.v);
    decide(*cloud, component.extinction);
  }

  TYN_HD void collide() {
    const Flight flight = land();
    go_on(pass_.collide(now_.state, flight, random(), now_.path));
  }

  TYN_HD void leave() {
    const Flight flight = land();
    go_on(pass_.leave(now_.state, flight, random(), now_.path));
  }

  /// Counts what the lane did since the last time.
  TYN_HD void write_down() {
    audit_.lookups += lookups_.lookups;
    audit_.octaves += lookups_.octaves;
    audit_.violations += lookups_.violations;
    deposit_audit(pass_.accounts.own().audit, audit_);
    audit_ = {};
    lookups_.lookups = lookups_.octaves = lookups_.violations = 0;
  }

 private:
  /// After a flight, and before the first.
  TYN_HD void go_on(bool goes_on) {
    now_.stage = goes_on ? Stage::walk : Stage::idle;
    if (!goes_on) return pass_.end(now_.state);
    ++audit_.flights;
    tracker_.start(now_.path.ray);
  }

  TYN_HD Flight land() {
    audit_.cells += tracker_.cells();
    return tracker_.land(now_.path);
  }

  // An audited decision takes all octaves.
  TYN_HD void decide(const NoiseCloud& cloud, float extinction) {
    const NoiseCloud::Squeeze& s = now_.squeeze;
    const bool audits = is_audited();
    if (audits ? s.octaves < cloud.octaves : s.answer == NoiseCloud::Squeeze::Answer::open) return;
    const bool real = s.answer == NoiseCloud::Squeeze::Answer::yes;
    meet(audits ? audit(grid_, bounds(), extinction * cloud.squeezed_density(s), now_.v, real,
                        lookups_)
                : real);
  }

  TYN_HD void meet(bool real) {
    audit_.real += real ? 1 : 0;
    const bool ends = tracker_.meet(real ? now_.component : virtual_particle);
    now_.stage = !ends ? Stage::walk : real ? Stage::collide : Stage::leave;
  }

  TYN_HD RandomStream random() const { return {pass_.seed, now_.stream, Pass::domain}; }
  TYN_HD bool is_audited() const { return tyndall::is_audited(now_.path.drawn.d); }
  TYN_HD std::size_t bounds() const {
    return static_cast<std::size_t>(now_.component) * grid_.cells() + tracker_.cell();
  }

  const Pass& pass_;
  const MajorantGrid& grid_;
  Saved now_;
  Tracker tracker_;
  Audit audit_;
  Lookups lookups_;
};

// Each choice costs about 20 instructions of voting. Counted with the emulated warp
// (docs/gpu.md): more steps at once leave too many lanes waiting for the last.
inline constexpr int steps_per_turn = 4, octaves_per_turn = 2;

/// \param count (stage) -> int, the lanes at it. \return where most are; idle ones count where
/// there are paths for them.
template <class Count>
TYN_HD Stage fullest_stage(bool has_paths, Count&& count) {
  Stage fullest = Stage::walk;
  int most = 0;
  for (int i = has_paths ? 0 : 1; i < stage_count; ++i) {
    const auto stage = static_cast<Stage>(i);
    const int lanes = count(stage);
    if (lanes > most) fullest = stage, most = lanes;
  }
  return fullest;
}

/// One turn of lanes that go in lockstep: the piece of work that most of them wait for, so that as
/// many as can be do something. `lanes` has
///   Stage fullest()                  at which most lanes are
///   void begin()                     gives the idle ones new paths, as long as there are any
///   void where(Stage, Work&& work)   calls work(lane) for the lanes at a stage
template <class Lanes>
TYN_HD_INLINED void take_turn(Lanes& lanes) {
  switch (lanes.fullest()) {
    case Stage::idle:
      lanes.begin();
      break;
    case Stage::walk:
      for (int i = 0; i < steps_per_turn; ++i)
        lanes.where(Stage::walk, [](auto& lane) { lane.walk(); });
      break;
    case Stage::draw:
      lanes.where(Stage::draw, [](auto& lane) { lane.draw(); });
      break;
    case Stage::add_octave:
      for (int i = 0; i < octaves_per_turn; ++i)
        lanes.where(Stage::add_octave, [](auto& lane) { lane.add_octave(); });
      break;
    case Stage::collide:
      lanes.where(Stage::collide, [](auto& lane) { lane.collide(); });
      break;
    case Stage::leave:
      lanes.where(Stage::leave, [](auto& lane) { lane.leave(); });
      break;
  }
}

}  // namespace tyndall
