/// \file
/// Lanes that run in lockstep, like the 32 of a warp. A loop over flights would wait for the
/// longest flight, and a loop over octaves for the hardest decision. So each lane is a state
/// machine with small pieces of work, and takes a new path when its path has ended. The pieces are
/// those of the plain loops, follow() and track(), in the same order for each path, so the results
/// are equal, bit for bit.
#pragma once

#include "tyndall/transport/passes.h"

namespace tyndall {

/// The next piece of work of a lane.
enum class Stage { idle, walk, draw, add_octave, collide, leave };
inline constexpr int stage_count = 6;

/// Whether a pass has paths, which run flight by flight.
template <class Pass>
inline constexpr bool has_lanes = requires {
  typename Pass::State;
};

/// Whether the paths of a pass use a majorant grid.
template <class Pass>
inline constexpr bool has_majorants = requires(const Pass& pass) {
  pass.sampler.grid(pass.medium);
};

/// A path that waits for a lane. Paths begin in a separate kernel, many at once. Starting a path is
/// a lot of code that runs once per path; in the lanes it would cost registers and instruction
/// cache.
template <class Pass>
struct Begun {
  std::uint64_t stream;  ///< of its random numbers
  Path path;
  typename Pass::State state;
};

/// Begins path `index` of a pass. \return whether it has a flight; if not, its end is recorded.
template <class Pass>
TYN_HD bool begin(const Pass& pass, std::uint64_t index, Begun<Pass>& begun) {
  begun.stream = pass.stream(index);
  const RandomStream random{pass.seed, begun.stream, Pass::domain};
  if (pass.begin(begun.state, random, begun.path)) return true;
  pass.end(begun.state);
  return false;
}

/// A lane of a pass with a majorant grid. It runs one path at a time.
template <class Pass>
class Lane {
 public:
  /// The state of a lane between launches. All zero: idle.
  struct Saved {
    Stage stage;
    std::uint64_t stream;  ///< of the path's random numbers
    Path path;
    typename Pass::State state;
    Tracker::Saved tracker;
    // The tentative collision under decision:
    int component;
    float v;
    Squeeze squeeze;
  };

  TYN_HD Lane(const Pass& pass, const Saved& saved)
      : pass_(pass),
        grid_(pass.sampler.grid(pass.medium)),
        now_(saved),
        tracker_(grid_, saved.tracker) {}

  TYN_HD Saved save() const {
    Saved saved = now_;
    saved.tracker = tracker_.save();
    // Nothing reads these again, so they need no registers between the pieces of work.
    saved.path.ray = {};
    saved.path.drawn.a = saved.path.drawn.b = 0;
    return saved;
  }

  TYN_HD Stage stage() const { return now_.stage; }

  // The pieces of work. Each expects the lane to be at its stage.

  TYN_HD void take(const Begun<Pass>& begun) {
    now_.stream = begun.stream;
    now_.path = begun.path;
    now_.state = begun.state;
    set_out();
  }

  TYN_HD void walk() {
    const Tracker::Event event = tracker_.cross(now_.path);
    if (event == Tracker::Event::crossed) return;
    now_.stage = event == Tracker::Event::within ? Stage::draw : Stage::leave;
  }

  TYN_HD void draw() {
    if (!tracker_.arrive(now_.path)) {
      now_.stage = Stage::leave;
      return;
    }
    ++count_.tentative;
    now_.v = tracker_.draw(now_.path, random());
    now_.component = pass_.medium.choose(grid_, tracker_.cell(), now_.v);
    if (now_.component == virtual_particle) return meet(false);
    const auto& component = pass_.medium.component(now_.component);
    const bool is_squeezed = if_squeezable(component.field, [&](const auto& field) {
      if (now_.v < grid_.lower[bounds()]) return meet(true);
      ++lookups_.lookups;
      now_.squeeze = field.begin_squeeze(component.to_field(tracker_.position()),
                                         component.extinction, now_.v);
      now_.stage = Stage::add_octave;
      decide(field, component.extinction);
    });
    if (is_squeezed) return;
    meet(is_real(grid_, now_.component, component, tracker_.cell(), now_.v, tracker_.position(),
                 lookups_, is_audited() ? Decision::audited : Decision::squeezed));
  }

  TYN_HD void add_octave() {
    const auto& component = pass_.medium.component(now_.component);
    if_squeezable(component.field, [&](const auto& field) {
      ++lookups_.octaves;
      field.add_octave(now_.squeeze, component.extinction, now_.v);
      decide(field, component.extinction);
    });
  }

  TYN_HD void collide() {
    const Flight flight = land();
    go_on(pass_.collide(now_.state, flight, random(), now_.path));
  }

  TYN_HD void leave() {
    if (tracker_.wrap(now_.path)) {
      now_.stage = Stage::walk;
      return;
    }
    const Flight flight = land();
    go_on(pass_.leave(now_.state, flight, random(), now_.path));
  }

  /// Adds the lane's counts since the last call to its account.
  TYN_HD void write_down() {
    deposit_audit(pass_.accounts.own().audit,
                  {count_.flights, count_.cells, count_.tentative, count_.real, lookups_.lookups,
                   lookups_.octaves, lookups_.violations, 0});
    count_ = {};
    lookups_.lookups = lookups_.octaves = lookups_.violations = 0;
  }

 private:
  /// Counts of an Audit in half as many registers: enough for one launch.
  struct Counts {
    std::uint32_t flights = 0, cells = 0, tentative = 0, real = 0;
  };

  TYN_HD void set_out() {
    now_.stage = Stage::walk;
    ++count_.flights;
    tracker_.start(now_.path.ray);
  }

  /// Ends a flight. \param goes_on whether the path has another one
  TYN_HD void go_on(bool goes_on) {
    if (goes_on) return set_out();
    now_.stage = Stage::idle;
    pass_.end(now_.state);
  }

  TYN_HD Flight land() {
    count_.cells += static_cast<std::uint32_t>(tracker_.cells());
    return tracker_.land(now_.path);
  }

  // An audited decision sums all octaves.
  template <Squeezable Field>
  TYN_HD void decide(const Field& field, float extinction) {
    const Squeeze& s = now_.squeeze;
    const bool audits = is_audited();
    if (audits ? s.octaves < field.octave_count() : s.answer == Squeeze::Answer::open) return;
    const bool real = s.answer == Squeeze::Answer::yes;
    meet(audits ? audit(grid_, bounds(), extinction * field.squeezed_density(s), now_.v, real,
                        lookups_)
                : real);
  }

  TYN_HD void meet(bool real) {
    count_.real += real ? 1 : 0;
    const bool ends = tracker_.meet(real ? now_.component : virtual_particle);
    now_.stage = !ends ? Stage::walk : real ? Stage::collide : Stage::leave;
  }

  TYN_HD RandomStream random() const { return {pass_.seed, now_.stream, Pass::domain}; }
  TYN_HD bool is_audited() const { return tyndall::is_audited(now_.path.drawn.d); }
  TYN_HD std::size_t bounds() const {
    return static_cast<std::size_t>(now_.component) * grid_.count() + tracker_.cell();
  }

  const Pass& pass_;
  const MajorantGrid& grid_;
  Saved now_;
  Tracker tracker_;
  Counts count_;
  Lookups lookups_;
};

/// A lane of ray marching. A piece of work is a fixed number of steps.
template <class Pass>
requires(!has_majorants<Pass>) class Lane<Pass> {
 public:
  struct Saved {
    Stage stage;
    std::uint64_t stream;
    Path path;
    typename Pass::State state;
    March::Saved march;
  };

  TYN_HD Lane(const Pass& pass, const Saved& saved)
      : pass_(pass), now_(saved), march_(pass.medium.whole, saved.march) {}

  TYN_HD Saved save() const {
    Saved saved = now_;
    saved.march = march_.save();
    return saved;
  }

  TYN_HD Stage stage() const { return now_.stage; }

  TYN_HD void take(const Begun<Pass>& begun) {
    now_.stream = begun.stream;
    now_.path = begun.path;
    now_.state = begun.state;
    set_out();
  }

  TYN_HD_INLINED void walk() {
    constexpr int steps = 16;
    const RandomStream random{pass_.seed, now_.stream, Pass::domain};
    TreeNodes nodes;
    TYN_ROLLED
    for (int i = 0; i < steps; ++i) {
      if (!march_.step(pass_.sampler.step, pass_.medium, now_.path, random, nodes, audit_))
        return land(random);
    }
  }

  // No lane reaches these stages.
  TYN_HD void draw() {}
  TYN_HD void add_octave() {}
  TYN_HD void collide() {}
  TYN_HD void leave() {}

  TYN_HD void write_down() {
    deposit_audit(pass_.accounts.own().audit, audit_);
    audit_ = {};
  }

 private:
  TYN_HD void set_out() {
    now_.stage = Stage::walk;
    ++audit_.flights;
    march_.start(now_.path.ray);
  }

  TYN_HD_INLINED void land(const RandomStream& random) {
    audit_.cells += march_.cells();
    const Flight flight = march_.land(now_.path);
    const bool goes_on = flight.end == Flight::End::collided
                             ? pass_.collide(now_.state, flight, random, now_.path)
                             : pass_.leave(now_.state, flight, random, now_.path);
    if (goes_on) return set_out();
    now_.stage = Stage::idle;
    pass_.end(now_.state);
  }

  const Pass& pass_;
  Saved now_;
  March march_;
  Audit audit_;
};

// Each choice of a stage costs 65 instructions of voting. More steps per turn leave more lanes
// waiting for the last one. Measured (docs/gpu.md).
inline constexpr int steps_per_turn = 3, octaves_per_turn = 4;

/// \param idle number of idle lanes for which there are paths \param count (stage) -> unsigned, the
/// lanes at another stage \return the stage with the most lanes; the earliest if several have.
template <class Count>
TYN_HD Stage fullest_stage(unsigned idle, Count&& count) {
  // The number in the high bits, the stage in the low ones: one maximum compares both.
  unsigned fullest = idle * 8u + static_cast<unsigned>(stage_count);
  for (int i = 1; i < stage_count; ++i) {
    const unsigned lanes = count(static_cast<Stage>(i));
    const unsigned here = lanes * 8u + static_cast<unsigned>(stage_count - i);
    fullest = here > fullest ? here : fullest;
  }
  return static_cast<Stage>(stage_count - static_cast<int>(fullest & 7u));
}

/// One turn of lanes in lockstep: the piece of work that most of them wait for, so that as many as
/// possible are active. `lanes` has
///   Stage fullest()                  the stage with the most lanes
///   void take()                      gives idle lanes new paths, as long as there are any
///   void where(Stage, Work&& work)   calls work(lane) for the lanes at a stage
template <class Lanes>
TYN_HD_INLINED void take_turn(Lanes& lanes) {
  switch (lanes.fullest()) {
    case Stage::idle:
      lanes.take();
      break;
    case Stage::walk:
      TYN_ROLLED
      for (int i = 0; i < steps_per_turn; ++i)
        lanes.where(Stage::walk, [](auto& lane) TYN_ALWAYS_INLINED { lane.walk(); });
      break;
    case Stage::draw:
      lanes.where(Stage::draw, [](auto& lane) { lane.draw(); });
      break;
    case Stage::add_octave:
      TYN_ROLLED
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
