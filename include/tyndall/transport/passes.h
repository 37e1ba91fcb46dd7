/// \file
/// The passes: trivially copyable functors of one index. Threads of the host and lanes of CUDA
/// kernels call them; these drivers contain no physics. The result for an index depends on the
/// index alone, and all results are integer sums.
#pragma once

#include "tyndall/transport/camera.h"
#include "tyndall/transport/detectors.h"
#include "tyndall/transport/film.h"
#include "tyndall/transport/illumination.h"
#include "tyndall/transport/ledger.h"
#include "tyndall/transport/light.h"
#include "tyndall/transport/walk.h"

namespace tyndall {

TYN_HD void deposit_weight(std::int64_t (&tally)[3], Vec3f weight) {
  deposit(tally[0], photon_units(weight.x));
  deposit(tally[1], photon_units(weight.y));
  deposit(tally[2], photon_units(weight.z));
}

TYN_HD void deposit_audit(Audit& tally, const Audit& part) {
  deposit(tally.flights, part.flights);
  deposit(tally.cells, part.cells);
  deposit(tally.tentative, part.tentative);
  deposit(tally.real, part.real);
  deposit(tally.lookups, part.lookups);
  deposit(tally.octaves, part.octaves);
  deposit(tally.violations, part.violations);
  deposit(tally.lit, part.lit);
}

/// The result of a real collision for a photon.
struct Scattering {
  Vec3f weight;  ///< after the collision; 0 if the photon ended
  bool absorbed, rouletted;
};

/// Multiplies the weight by the albedo in each channel, then plays Russian roulette. The survival
/// probability is the fraction of the largest channel that is left: weights never grow, and a grey
/// photon keeps weight 1 to its end.
TYN_HD Scattering scatter(Vec3f weight, Vec3f albedo, const RandomStream& random,
                          std::uint32_t event) {
  const Vec3f scattered = weight * albedo;
  const float largest_weight = largest(weight), most = largest(scattered);
  if (!(most > 0.0f)) return {{0, 0, 0}, true, false};
  if (most >= largest_weight) return {scattered, false, false};
  const float survival = divide(most, largest_weight);
  if (uniform(random.block(event, Purpose::scatter).a) >= survival) return {{0, 0, 0}, false, true};
  const Vec3f kept = inverse(survival) * scattered;
  return {{min(kept.x, largest_weight), min(kept.y, largest_weight), min(kept.z, largest_weight)},
          false,
          false};
}

/// Starts the next flight of a path that the ground at `face` reflects. Directions have the density
/// cosine/pi.
TYN_HD void reflect(const Box& box, Face face, const RandomStream& random, Path& path) {
  path.draw(random);
  path.ray = {onto_face(box, face, path.ray.origin),
              direction_around(inward_normal(face), sqrt(uniform_symmetric(path.drawn.c)),
                               uniform_symmetric(path.drawn.d))};
}

/// Runs path `index` of a pass from beginning to end, flight by flight.
template <class Pass>
TYN_HD void follow(const Pass& pass, std::uint64_t index) {
  const RandomStream random{pass.seed, pass.stream(index), Pass::domain};
  typename Pass::State state;
  Path path;
  Audit audit;
  bool goes_on = pass.begin(state, random, path);
  while (goes_on) {
    const Flight flight = pass.sampler.fly(pass.medium, path, random, audit);
    goes_on = flight.end == Flight::End::collided ? pass.collide(state, flight, random, path)
                                                  : pass.leave(state, flight, random, path);
  }
  pass.end(state);
  deposit_audit(pass.accounts.own().audit, audit);
}

/// The state of a photon.
struct Burden {
  Vec3f weight;
  int group;    ///< of its light
  bool scores;  ///< whether it deposits light at its next collision
  Track track{};
};

/// Traces photon `index` from its light to its one fate.
template <class Medium, class Sampler>
struct ShootPass {
  Medium medium;
  Sampler sampler;
  Lights lights;
  std::uint64_t seed;
  IlluminationTally illumination;
  Accounts accounts;
  Detectors detectors{};

  static constexpr Domain domain = Domain::photon;

  TYN_HD void operator()(std::uint64_t index) const { follow(*this, index); }

  // The steps of a photon and their tallies, for every driver. They return false if the photon
  // ends; otherwise `path` is its next flight.

  using State = Burden;

  TYN_HD std::uint64_t stream(std::uint64_t index) const { return index; }

  /// \return false if the photon misses the medium, or was rejected.
  TYN_HD bool begin(Burden& burden, const RandomStream& random, Path& path) const {
    const RandomBlock first = random.block(0, Purpose::emission);
    const RandomBlock aim = random.block(0, Purpose::aim);
    const Emitter& emitter = lights.sample(first.a);
    const Photon photon = emitter.is_medium() ? emitter.medium.emit(medium, first, aim,
                                                                    random.block(0, Purpose::place))
                                              : emit(emitter, lights, medium.whole.box, first, aim);
    path = {photon.ray, exponential(first.d), 0, {}};
    burden = {photon.weight, illumination.cells.groups > 1 ? emitter.group : 0, !emitter.is_apart};
    Ledger& ledger = accounts.own().ledger;
    deposit(ledger.shot, 1);
    deposit_weight(ledger.shot_power, burden.weight);
    if (largest(burden.weight) > 0.0f && enter(medium.whole.box, path.ray)) return true;
    deposit(ledger.missed, 1);
    deposit_weight(ledger.missed_power, burden.weight);
    return false;
  }

  /// Handles a flight that escaped or stalled.
  TYN_HD bool leave(Burden& burden, const Flight& flight, const RandomStream& random,
                    Path& path) const {
    burden.track.length = burden.track.length + flight.length;
    const bool escaped = flight.end == Flight::End::escaped;
    const Box& box = medium.whole.box;
    const bool is_ground = escaped && box.is_ground(flight.face);
    if (is_ground && burden.track.scatterings == 0) deposit(accounts.own().audit.lit, 1);
    // Without a ground, nothing is reflected.
    const Vec3f albedo = is_ground ? box.ground_albedo[flight.face] : Vec3f{0, 0, 0};
    const Scattering next = scatter(burden.weight, albedo, random, path.event + 1);
    Ledger& ledger = accounts.own().ledger;
    std::int64_t taken[3];
    settle(burden.weight, albedo, next, escaped ? ledger.escaped[flight.face] : ledger.stalled,
           escaped ? ledger.escaped_power[flight.face] : ledger.stalled_power, taken);
    if (escaped && detectors.sums)
      detectors.escape(flight.face, path.ray.origin, path.ray.direction, burden.track, taken);
    if (next.absorbed || next.rouletted) return false;
    burden.weight = next.weight;
    burden.scores = true;  // it no longer comes straight from its light
    reflect(box, flight.face, random, path);
    return true;
  }

  /// Handles a flight that ended at a real collision.
  TYN_HD bool collide(Burden& burden, const Flight& flight, const RandomStream& random,
                      Path& path) const {
    const auto cell = [&] { return illumination.cells.cell_of(path.ray.origin); };
    if (!interact(burden, flight, path.ray, random, path.event, cell)) return false;
    path.ray.direction = medium.component(flight.component)
                             .phase.sample(path.ray.direction, uniform_symmetric(path.drawn.c),
                                           uniform_symmetric(path.drawn.d));
    return true;
  }

  /// A real collision except for the new direction: deposit, absorption, Russian roulette.
  /// \param arrival point of collision and incoming direction \param cell () -> the cell of the
  /// illumination grid there \return false if the collision ends the photon.
  template <class Cell>
  TYN_HD bool interact(Burden& burden, const Flight& flight, const Ray& arrival,
                       const RandomStream& random, std::uint32_t event, Cell&& cell) const {
    burden.track.length = burden.track.length + flight.length;
    if (burden.track.scatterings++ == 0) deposit(accounts.own().audit.lit, 1);
    const auto& component = medium.component(flight.component);
    if (component.scatters() && burden.scores)
      illumination.score(cell(), arrival.direction, burden.weight, burden.group);
    burden.scores = true;
    return survive(flight.component, component.albedo, arrival.origin, random, event,
                   burden.weight);
  }

  /// All tallies have been made by then.
  TYN_HD void end(const Burden&) const {}

 private:
  /// Absorption and roulette at a collision at `p`. \return false if they end the photon.
  TYN_HD bool survive(int component, Vec3f albedo, Vec3f p, const RandomStream& random,
                      std::uint32_t event, Vec3f& weight) const {
    if (albedo.x == 1.0f && albedo.y == 1.0f && albedo.z == 1.0f) return true;  // unchanged
    const Scattering next = scatter(weight, albedo, random, event);
    Ledger& ledger = accounts.own().ledger;
    std::int64_t absorbed[3];
    settle(weight, albedo, next, ledger.absorbed[component], ledger.absorbed_power[component],
           absorbed);
    if (detectors.sums) detectors.absorb(p, absorbed);
    weight = next.weight;
    return !next.absorbed && !next.rouletted;
  }

  // Tallies the power lost at a collision or a face: the part `taken` there goes to `power`, and
  // `ended` counts a photon that ends there; the rest goes to (or comes from) the roulette. In
  // integers, so that the sum over the photon's life closes exactly.
  TYN_HD void settle(Vec3f weight, Vec3f albedo, const Scattering& next, std::int64_t& ended,
                     std::int64_t (&power)[3], std::int64_t (&taken)[3]) const {
    Ledger& ledger = accounts.own().ledger;
    const float before[3] = {weight.x, weight.y, weight.z};
    const float share[3] = {albedo.x, albedo.y, albedo.z};
    const float after[3] = {next.weight.x, next.weight.y, next.weight.z};
    for (int c = 0; c < 3; ++c) {
      const int scattered = photon_units(before[c] * share[c]);
      taken[c] = photon_units(before[c]) - scattered;
      const int roulette = scattered - photon_units(after[c]);
      if (taken[c] != 0) deposit(power[c], taken[c]);
      if (roulette != 0) deposit(ledger.roulette_power[c], roulette);
    }
    if (next.absorbed) deposit(ended, 1);
    if (next.rouletted) deposit(ledger.rouletted, 1);
  }
};

/// Computes D of cell `index` (see illumination.h): the scattering extinction at jittered points,
/// strata x strata x strata per cell, and 8 times as many in a cell with little medium. If the
/// points miss density that photons hit, N / D is a white speck.
template <class Medium>
struct MatterPass {
  Medium medium;
  std::uint64_t seed;
  IlluminationCells cells;
  Vec3f cell_size;
  int strata;
  float scale;  ///< turns sigma_t into integers: 2^40 over a power of two not below any sigma_t
                ///< [length]
  std::int64_t* matter;  ///< [cells] sum over (2 strata)^3 points, times scale

  TYN_HD void operator()(std::uint64_t index) const {
    matter[index] = total(index, [this](std::uint64_t cell, int n, std::uint32_t event) {
      Measure all{0, 0};
      Lookups lookups;
      for (int m = 0; m < n * n * n; ++m) {
        const Vec3f p = point(cell, n, event, m);
        if (may_have_matter(p)) all.add(to_units(scattering_sigma_t(p, lookups)));
      }
      return all;
    });
  }

  // The parts of the pass, for every driver.

  struct Measure {
    std::int64_t sum;
    int hits;  // points in the medium

    TYN_HD void add(std::int64_t here) {
      sum += here;
      hits += here > 0 ? 1 : 0;
    }
  };

  /// \param measure (cell, n, event) -> Measure at n x n x n points, which differ between events.
  /// A first measure decides how many points are needed. It is not part of the result, because it
  /// would bias it.
  template <class MeasureCell>
  TYN_HD std::int64_t total(std::uint64_t index, MeasureCell&& measure) const {
    if (is_empty(index)) return 0;
    const bool is_thin = measure(index, 2, 0u).hits < 4;
    return is_thin ? measure(index, 2 * strata, 1u).sum : 8 * measure(index, strata, 2u).sum;
  }

  /// Point `m` of n x n x n in cell `index`.
  TYN_HD Vec3f point(std::uint64_t index, int n, std::uint32_t event, int m) const {
    const int a = m % n, b = m / n % n, c = m / (n * n);
    const float inverse = 1.0f / static_cast<float>(n);
    const std::uint64_t stream =
        index * static_cast<std::uint64_t>(n * n * n) + static_cast<std::uint64_t>(m);
    const RandomBlock r =
        RandomStream{seed, stream, Domain::matter}.block(event, Purpose::emission);
    return place(index, {(static_cast<float>(a) + uniform(r.a)) * inverse,
                         (static_cast<float>(b) + uniform(r.b)) * inverse,
                         (static_cast<float>(c) + uniform(r.c)) * inverse});
  }

  /// \return the position at `fraction` of the edges of a cell.
  TYN_HD Vec3f place(std::uint64_t index, Vec3f fraction) const {
    const Cells::Place at = cells.place(index);
    return cell_size
           * Vec3f{static_cast<float>(at.i) + fraction.x, static_cast<float>(at.j) + fraction.y,
                   static_cast<float>(at.k) + fraction.z};
  }

  static constexpr float rounding = 1e-3f;  ///< of place(), in edges of a cell; a generous bound

  /// \return whether all super-voxels that the cell overlaps are empty: no medium is in the cell.
  /// Cells of a brick beyond the box are empty, too.
  TYN_HD bool is_empty(std::uint64_t index) const {
    if (cells.bricks.table) {
      const Cells::Place at = cells.place(index);
      if (index < cells.first() || at.i >= cells.nx || at.j >= cells.ny || at.k >= cells.nz)
        return true;
    }
    const Vec3f low = place(index, {-rounding, -rounding, -rounding}),
                high = place(index, {1 + rounding, 1 + rounding, 1 + rounding});
    const MajorantGrid& grid = medium.super_voxels;
    const Cells::Place first = grid.place_of(low), last = grid.place_of(high);
    for (int k = first.k; k <= last.k; ++k)
      for (int j = first.j; j <= last.j; ++j)
        for (int i = first.i; i <= last.i; ++i)
          if (grid.total[grid.index(i, j, k)] > 0.0f) return false;
    return true;
  }

  TYN_HD bool may_have_matter(Vec3f p) const {
    return medium.super_voxels.total[medium.super_voxels.cell_of(p)] > 0.0f;
  }
  /// Smaller extinctions round to 0 [1/length]. A few octaves may suffice to find that.
  TYN_HD float least() const { return 0.25f / scale; }
  TYN_HD std::int64_t to_units(float sigma_t) const { return round_to_integer(sigma_t * scale); }

 private:
  TYN_HD float scattering_sigma_t(Vec3f p, Lookups& lookups) const {
    float sigma_t = 0.0f;
    for (int c = 0; c < medium.count(); ++c) {
      const auto& component = medium.component(c);
      if (component.scatters() && component.exceeds(p, least(), lookups))
        sigma_t = sigma_t + component.sigma_t(p, lookups.nodes);
    }
    return sigma_t;
  }
};

/// The state of a camera path: the light gathered so far, the purpose of its flight, and how it
/// continues afterwards.
struct Sight {
  std::uint64_t pixel = 0;
  SampleSum sum;
  Vec3f albedo{0, 0, 0};  ///< at the first hit
  Vec3f throughput{1, 1, 1};
  int collisions = 0;        ///< with components that scatter, and with grounds
  bool hit = false;          ///< it has hit the medium or a ground
  bool is_negative = false;  ///< the sign of `throughput`
  float rest = 1;  ///< factor of the throughput from the next collision on: 1, or the ratio of the
                   ///< part of the phase function not read from the grid to the whole; 0: the path
                   ///< ends at that collision
  float pdf = 0;   ///< of the direction that it scattered into [1/sr], for MIS

  // A shadow ray, and the path after it:
  bool in_shadow_walk = false;
  bool stops = false;     ///< the path ends after the shadow ray
  Vec3f direct{0, 0, 0};  ///< radiance to add if the light is not occluded
  int group = 0;          ///< of that light
  Ray onward{{0, 0, 0}, {0, 0, 1}};
  float tau = 0;
};

/// Gathers a sample of a pixel by a path from the camera. Samples of one pixel follow each other,
/// because their rays hit the same part of the medium, which is then in the cache. At each
/// collision the path adds emission, and the light of one light source by next-event estimation.
/// After `bounces` scatterings it reads light that was scattered before from the illumination grid.
/// Where the grid's harmonics lack light that the phase function P needs, the path continues: it
/// adds the light from a direction sampled from P, less the grid's own radiance from there
/// (take_back), times (P - S) / P of either sign, where S is Phase::smooth: see split_phase(). For
/// such a P, some directions are sampled about the direction to a light (turn_to_light). Lights
/// that rays can hit are sampled both by next-event estimation and by the phase function, with MIS
/// by the balance heuristic [Veach1997]. Without a grid this is a path tracer.
template <class Medium, class Sampler>
struct GatherPass {
  Medium medium;
  Sampler sampler;
  Camera camera;
  IlluminationField illumination;  ///< numerator null: no grid
  DirectLights lights;
  Vec3f background;  ///< [W/(area sr)] seen by camera rays that hit nothing
  int bounces;       ///< scatterings before the grid is read
  bool is_apart;     ///< the grid lacks singly scattered light of `lights`
  std::uint64_t seed;
  SampleRange samples;
  Film film;
  Accounts accounts;
  const std::uint32_t* pixels = nullptr;  ///< to gather, in order; null: all

  static constexpr Domain domain = Domain::pixel_sample;

  TYN_HD void operator()(std::uint64_t index) const { follow(*this, index); }

  using State = Sight;

  /// \return the random stream of path `index`.
  TYN_HD std::uint64_t stream(std::uint64_t index) const {
    const std::uint64_t i = index / samples.count;
    return camera.window.stream(pixels ? pixels[i] : i, samples.begin + index % samples.count);
  }

  // The steps of a sample, for every driver. They return false if the sample is complete; otherwise
  // `path` is its next flight.

  TYN_HD bool begin(Sight& sight, const RandomStream& random, Path& path) const {
    sight = {};
    sight.pixel = camera.window.pixel(random.index);
    const RandomBlock first = random.block(0, Purpose::emission);
    path = {camera.sample(random, first), exponential(first.d), 0, {}};
    sight.onward = path.ray;
    const Entry entry = approach(medium.whole.box, path.ray);
    if (entry == Entry::open) return true;
    if (entry == Entry::ground) {  // the back of a ground is dark
      see_lights(sight, sight.onward.direction, distance_to_ground(sight, path));
      sight.hit = true;
      return false;
    }
    see_lights(sight, sight.onward.direction, largest_float);
    see_background(sight);
    return false;
  }

  TYN_HD bool leave(Sight& sight, const Flight& flight, const RandomStream& random,
                    Path& path) const {
    const bool is_ground =
        flight.end == Flight::End::escaped && medium.whole.box.is_ground(flight.face);
    if (sight.in_shadow_walk) {
      // A ground hides lights beyond it, but not those within its rounding.
      const bool is_hidden = is_ground && beyond_rounding * flight.length < path.reach;
      if (flight.end == Flight::End::escaped && !is_hidden)
        add(sight, sight.direct, sight.collisions == 1 ? Part::single : Part::multiple,
            sight.group);
      return resume(sight, path);
    }
    if (is_ground) return meet_ground(sight, flight.face, random, path);
    see_lights(sight, path.ray.direction, largest_float);
    if (sight.collisions == 0) see_background(sight);
    return false;
  }

  /// \param path starts at the collision that ended `flight`.
  TYN_HD bool collide(Sight& sight, const Flight& flight, const RandomStream& random,
                      Path& path) const {
    if (sight.in_shadow_walk) return resume(sight, path);
    const auto& component = medium.component(flight.component);
    const Vec3f p = path.ray.origin, direction = path.ray.direction;
    if (lights.any_hit()) see_lights(sight, direction, length(p - sight.onward.origin));
    if (!take_rest(sight)) return false;
    if (!sight.hit) sight.albedo = component.albedo;
    sight.hit = true;
    if (component.emission)
      add(sight, sight.throughput * component.emitted(p),
          sight.collisions == 0 ? Part::emission : Part::multiple, film.group_count - 2);
    if (!component.scatters()) return false;
    const Phase& phase = component.phase;
    const bool reads = illumination.numerator && sight.collisions >= bounces;
    const Vec3f scattered = sight.throughput * component.albedo;
    ++sight.collisions;
    if (reads) read_grid(sight, p, direction, scattered, phase);
    sight.throughput = scatter(sight.throughput, component.albedo, random, path.event).weight;
    sight.onward = {p, phase.sample(direction, uniform_symmetric(path.drawn.c),
                                    uniform_symmetric(path.drawn.d))};
    sight.tau = path.tau;
    if (phase.is_split && lights.any_sampled())
      sight.throughput = turn_to_light(sight, phase, direction, random, path) * sight.throughput;
    const float cosine = dot(direction, sight.onward.direction);
    sight.pdf = phase.pdf(cosine);
    sight.rest = reads ? rest_of(phase, cosine, sight.pdf, random, path.event) : 1.0f;
    if (reads && sight.rest != 0.0f) take_back(sight);
    // If the grid is not read or lacks singly scattered light, this collision scatters light
    // straight from the lights by the whole phase function, else by the rest of it.
    const bool takes_lights = !reads || is_apart || phase.is_split;
    sight.stops = !(largest(sight.throughput) > 0.0f)
                  || (sight.rest == 0.0f && !(is_apart && lights.any_hit()));
    if (!takes_lights || !lights.any_sampled()) return resume(sight, path);
    return ask_light(sight, scattered, random, path, [&](Vec3f to_light) {
      const float towards = dot(direction, to_light), whole = phase.evaluate(towards);
      return Weighed{is_apart || !reads ? whole : whole - phase.smooth(towards), whole};
    });
  }

  TYN_HD void end(const Sight& sight) const {
    film.finish(sight.pixel, sight.sum, sight.hit, sight.albedo);
  }

 private:
  static constexpr float beyond_rounding = 1.0f + 1e-5f;
  /// Fraction of the directions sampled about a light at the first collision. At the n-th it is 1/n
  /// of this, so that the weights of long paths grow no faster than a small power of their length.
  static constexpr float turned_fraction = 0.25f;

  /// \param path ends at a ground
  TYN_HD static float distance_to_ground(const Sight& sight, const Path& path) {
    return beyond_rounding * length(path.ray.origin - sight.onward.origin);
  }

  /// Handles a hit of a ground, as collide() does for the medium. It reflects, and reads no grid.
  TYN_HD bool meet_ground(Sight& sight, Face face, const RandomStream& random, Path& path) const {
    const Box& box = medium.whole.box;
    const Vec3f albedo = box.ground_albedo[face], normal = inward_normal(face);
    see_lights(sight, path.ray.direction, distance_to_ground(sight, path));
    if (!take_rest(sight)) return false;
    if (!sight.hit) sight.albedo = albedo;
    sight.hit = true;
    if (!(largest(albedo) > 0.0f)) return false;
    ++sight.collisions;
    reflect(box, face, random, path);
    const Vec3f reflected = sight.throughput * albedo;
    sight.throughput = scatter(sight.throughput, albedo, random, path.event).weight;
    sight.rest = 1.0f;
    sight.stops = !(largest(sight.throughput) > 0.0f);
    sight.onward = path.ray;
    sight.pdf = (1.0f / pi) * dot(normal, path.ray.direction);
    sight.tau = path.tau;
    if (!lights.any_sampled()) return resume(sight, path);
    return ask_light(sight, reflected, random, path, [&](Vec3f to_light) {
      const float density = (1.0f / pi) * dot(normal, to_light);
      return Weighed{density, density};
    });
  }

  /// Samples a fraction of the directions from `phase` about the direction to a light. If the phase
  /// function has a peak, light that turns by a large angle here and by a small one at the next
  /// collision would otherwise be sampled rarely, with a large weight.
  /// \return the phase function over the density of `sight.onward.direction` (one-sample MIS with
  /// the balance heuristic, given the light): at most 1 / (1 - turned_fraction).
  TYN_HD float turn_to_light(Sight& sight, const Phase& phase, Vec3f direction,
                             const RandomStream& random, const Path& path) const {
    const Vec3f to_light =
        lights.sample(path.ray.origin, random.block(path.event, Purpose::light)).direction;
    const float fraction = divide(turned_fraction, static_cast<float>(sight.collisions));
    if (uniform(random.block(path.event, Purpose::scatter).c) < fraction)
      sight.onward.direction =
          phase.sample(to_light, uniform_symmetric(path.drawn.c), uniform_symmetric(path.drawn.d));
    const float density = phase.pdf(dot(direction, sight.onward.direction));
    const float about_light = phase.pdf(dot(to_light, sight.onward.direction));
    return divide(density, max(lerp(density, about_light, fraction), 1e-30f));
  }

  /// \return the ratio P_rest / P at `cosine`, of either sign, where P_rest is the part of `phase`
  /// that the grid does not integrate; by Russian roulette 0 or at least 1 in magnitude. Directions
  /// are sampled from P, so its mean square is below 1, and the weights of paths stay bounded.
  TYN_HD static float rest_of(const Phase& phase, float cosine, float density,
                              const RandomStream& random, std::uint32_t event) {
    if (!phase.is_split) return 0.0f;
    const float rest = 1.0f - divide(phase.smooth(cosine), max(density, 1e-30f));
    if (abs(rest) >= 1.0f) return rest;
    if (uniform(random.block(event, Purpose::scatter).b) >= abs(rest)) return 0.0f;
    return rest < 0.0f ? -1.0f : 1.0f;
  }

  /// Multiplies the throughput by `rest` at the next collision. \return false if the path ends.
  TYN_HD static bool take_rest(Sight& sight) {
    sight.throughput = abs(sight.rest) * sight.throughput;
    sight.is_negative = sight.is_negative != (sight.rest < 0.0f);
    return sight.rest != 0.0f;
  }

  /// A scattering function at a direction.
  struct Weighed {
    float value;    ///< fraction of the light that goes from there to the camera [1/sr]
    float density;  ///< pdf of `sight.onward` there [1/sr]; below 0: no light comes from there
  };

  /// Starts the shadow ray of next-event estimation at the origin of `path`. \param weigh
  /// (direction to the light) -> Weighed
  template <class Weigh>
  TYN_HD bool ask_light(Sight& sight, Vec3f scattered, const RandomStream& random, Path& path,
                        Weigh&& weigh) const {
    const RandomBlock drawn = random.block(path.event, Purpose::light);
    const LightSample light = lights.sample(path.ray.origin, drawn);
    const Weighed f = weigh(light.direction);
    if (f.density < 0.0f) return resume(sight, path);
    const float share = light.pdf > 0.0f ? light.pdf / (light.pdf + f.density) : 1.0f;
    sight.direct = (share * f.value) * (scattered * light.irradiance);
    sight.group = light.group;
    sight.in_shadow_walk = true;
    path.ray.direction = light.direction;
    path.tau = exponential(drawn.d);
    path.reach = light.distance;
    return true;
  }

  TYN_HD static bool resume(Sight& sight, Path& path) {
    sight.in_shadow_walk = false;
    path.ray = sight.onward;
    path.tau = sight.tau;
    path.reach = largest_float;
    return !sight.stops;
  }

  TYN_HD void add(Sight& sight, Vec3f radiance, Part part, int group) const {
    film.add(sight.pixel, sight.is_negative ? -1.0f * radiance : radiance, part, group, sight.sum);
  }

  /// Adds lights that a flight from `sight.onward.origin`, `distance` long, hits.
  TYN_HD void see_lights(Sight& sight, Vec3f direction, float distance) const {
    // The grid may hold their light for the smooth part of the phase function.
    const float rest = is_apart ? 1.0f : sight.rest;
    const float before = sight.collisions == 0 ? camera.before(direction) : 0.0f;
    lights.intersect(
        {sight.onward.origin, direction}, distance,
        [&](Vec3f radiance, float pdf, int group) {
          const float share = sight.collisions == 0 ? 1.0f : sight.pdf / (sight.pdf + pdf);
          add(sight, (rest * share) * (sight.throughput * radiance),
              sight.collisions == 0   ? Part::unscattered
              : sight.collisions == 1 ? Part::single
                                      : Part::multiple,
              group);
        },
        before);
  }

  /// Subtracts the grid's radiance from the direction in which the path continues.
  TYN_HD void take_back(Sight& sight) const {
    const IlluminationField::Spot spot = illumination.spot(sight.onward.origin);
    for (int group = 0; group < illumination.cells.groups; ++group) {
      add(sight,
          (-sight.rest * sight.throughput)
              * illumination.radiance_at(spot, -1.0f * sight.onward.direction, group),
          Part::multiple, group);
    }
  }

  TYN_HD void see_background(Sight& sight) const {
    add(sight, background, Part::unscattered, film.group_count - 1);
  }

  TYN_HD void read_grid(Sight& sight, Vec3f p, Vec3f direction, Vec3f scattered,
                        const Phase& phase) const {
    const IlluminationField::Spot spot = illumination.spot(p);
    for (int group = 0; group < illumination.cells.groups; ++group) {
      add(sight, scattered * illumination.scattered_at(spot, -1.0f * direction, phase, group),
          Part::multiple, group);
    }
  }
};

}  // namespace tyndall
