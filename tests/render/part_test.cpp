/// \file
/// Parts of a render add up to the whole, bit for bit.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <stdexcept>

#include "support/forwarding.h"
#include "support/scenes.h"
#include "tyndall/render/error.h"
#if TYNDALL_RAPIDCHECK
#include <rapidcheck.h>
#endif

namespace tyndall::test {
namespace {

Scene small() {
  Scene scene = coloured();
  scene.photons = 400;
  scene.samples = 11;
  scene.illumination_resolution = {4, 4, 4};
  scene.camera.resolution = {5, 4};
  scene.detectors.flux = {3, 3};
  scene.detectors.absorbed = {2, 2, 2};
  scene.lights.push_back(scene::EnvironmentLight{{0.1, 0.2, 1}});
  return scene;
}

struct Asked {
  std::optional<IndexRange> photons, samples;
};

Partial part_of(const Scene& scene, const Asked& asked, const Partial* light = nullptr,
                std::uint64_t batch = 0) {
  RenderOptions options;
  options.photons = asked.photons;
  options.samples = asked.samples;
  options.batch = batch;
  if (light) options.photons = {0, 0};
  const auto backend = make_cpu_backend(2);
  Renderer renderer(scene, *backend, options);
  if (light) renderer.resume(*light, "light");
  EXPECT_TRUE(renderer.run());
  return without_light(renderer.part());
}

bool same(const RenderResult& a, const RenderResult& b) {
  return a.hashes.tallies == b.hashes.tallies && a.hashes.pixels == b.hashes.pixels;
}

/// Merges the parts in the given order. \pre at least one part
Partial sum(std::vector<Partial> parts) {
  Partial all = std::move(parts.front());
  for (std::size_t i = 1; i < parts.size(); ++i) merge(all, "a", std::move(parts[i]), "b");
  return all;
}

// ---- Ranges

TEST(RangesTest, join_where_they_touch) {
  Ranges ranges;
  ranges.add({5, 9});
  ranges.add({1, 3});
  ranges.add({12, 12});  // empty
  EXPECT_EQ(ranges.text(), "1:3, 5:9");
  ranges.add({3, 5});
  EXPECT_EQ(ranges.text(), "1:9");
  EXPECT_EQ(ranges.count(), 8u);
  EXPECT_EQ(Ranges().text(), "none");
}

TEST(RangesTest, know_what_they_lack_and_share) {
  const Ranges ranges({{2, 4}, {6, 8}});
  EXPECT_EQ(ranges.missing({0, 10}).text(), "0:2, 4:6, 8:10");
  EXPECT_EQ(ranges.missing({3, 7}).text(), "4:6");
  EXPECT_EQ(ranges.missing({6, 8}).text(), "none");
  EXPECT_EQ(ranges.common(Ranges({{3, 7}})).text(), "3:4, 6:7");
}

// ---- Parts

TEST(Parts, samples_in_any_parts_make_the_whole_picture) {
  const Scene scene = small();
  const RenderResult whole = render(scene, *make_cpu_backend());
  EXPECT_TRUE(whole.is_complete);
  for (const std::uint64_t cut : {1u, 4u, 10u}) {
    const Partial both =
        sum({part_of(scene, {{}, IndexRange{cut, 11}}), part_of(scene, {{}, IndexRange{0, cut}})});
    EXPECT_TRUE(both.is_complete());
    EXPECT_TRUE(same(develop(both), whole)) << cut;
  }
}

TEST(Parts, a_range_of_samples_is_the_same_picture_wherever_it_ends) {
  const Scene scene = small();
  const RenderResult part = develop(part_of(scene, {{}, IndexRange{0, 6}}));
  EXPECT_FALSE(part.is_complete);
  EXPECT_EQ(part.samples.text(), "0:6");
  EXPECT_TRUE(same(develop(part_of(scene, {{}, IndexRange{0, 6}}, nullptr, 3)), part));
  // A time limit ends the render there.
  const auto backend = make_cpu_backend();
  RenderOptions options;
  options.go_on = [](Renderer& r, Moment moment) {
    return moment == Moment::batch || r.part().samples().count() < 6;
  };
  Renderer left(scene, *backend, options);
  EXPECT_FALSE(left.run());
  ASSERT_EQ(left.part().samples().text(), "0:6");
  EXPECT_TRUE(same(left.result(), part));
}

// Replicates one after another, or some or all in turns; the rest of the render in another way.
TEST(Parts, a_render_left_anywhere_goes_on_to_the_same_end) {
  const Scene scene = small();
  const RenderResult whole = render(scene, *make_cpu_backend());
  for (const auto& [first_lights, second_lights] : {std::pair{1, 1}, {8, 1}, {1, 8}, {3, 8}}) {
    for (int stop_at = 1; stop_at < 200; stop_at += first_lights == 1 ? 3 : 13) {
      int moments = 0;
      RenderOptions options;
      options.batch = 7;
      options.most_lights = first_lights;
      options.go_on = [&](Renderer&, Moment) { return ++moments < stop_at; };
      const auto backend = make_cpu_backend(1);
      Renderer first(scene, *backend, options);
      if (first.run()) {
        EXPECT_GT(stop_at, 50) << "too few moments for a test";
        break;
      }
      const Partial left = first.part();
      options.go_on = {};
      options.batch = 23;
      options.most_lights = second_lights;
      Renderer second(scene, *backend, options);
      second.resume(left, "checkpoint");
      ASSERT_TRUE(second.run());
      ASSERT_TRUE(same(second.result(), whole))
          << "left at moment " << stop_at << " of " << first_lights;
    }
  }
}

TEST(Parts, gathered_by_turns_hold_the_light_of_as_many_as_they_may) {
  Scene scene = small();
  scene.samples = 64;
  const RenderResult whole = render(scene, *make_cpu_backend());
  for (const int lights : {1, 3, 8}) {
    RenderOptions options;
    options.most_lights = lights;
    int most = 0;
    bool were_uneven = false;
    options.go_on = [&](Renderer& r, Moment moment) {
      int held = 0;
      std::uint64_t fewest = 64, samples = 0;
      for (const Replicate& replicate : r.part().replicates) {
        held += !replicate.light.empty();
        if (replicate.samples.empty()) continue;
        fewest = std::min(fewest, replicate.samples.count());
        samples = std::max(samples, replicate.samples.count());
      }
      most = std::max(most, held);
      were_uneven = were_uneven || (moment == Moment::round && samples > fewest + fewest / 2 + 1);
      return true;
    };
    const auto backend = make_cpu_backend(2);
    Renderer renderer(scene, *backend, options);
    EXPECT_TRUE(renderer.run());
    EXPECT_TRUE(same(renderer.result(), whole));
    EXPECT_EQ(most, lights);
    EXPECT_FALSE(were_uneven);
  }
}

TEST(Parts, that_nothing_is_missing_of_are_done_whoever_ends_them) {
  const Scene scene = small();
  RenderOptions options;
  options.go_on = [](Renderer& r, Moment moment) {
    return moment == Moment::batch || r.part().samples().count() < 11;
  };
  const auto backend = make_cpu_backend();
  Renderer renderer(scene, *backend, options);
  EXPECT_TRUE(renderer.run());
}

TEST(Parts, are_looked_at_without_harm) {
  const Scene scene = small();
  const RenderResult whole = render(scene, *make_cpu_backend());
  for (const int lights : {1, 8}) {
    RenderOptions options;
    options.batch = 16;
    options.most_lights = lights;
    int previews = 0;
    options.go_on = [&](Renderer& renderer, Moment) {
      if (renderer.has_picture()) {
        EXPECT_EQ(renderer.result().picture.rgba.size(), 80u);
      }
      // The preview uses other light than the unfinished slice.
      if (renderer.has_preview()) {
        EXPECT_TRUE(renderer.preview(0.001).is_preview);
        ++previews;
      }
      return true;
    };
    const auto backend = make_cpu_backend();
    Renderer renderer(scene, *backend, options);
    EXPECT_TRUE(renderer.run());
    EXPECT_GT(previews, 0);
    EXPECT_TRUE(same(renderer.result(), whole)) << lights;
  }
}

TEST(Parts, end_with_the_time) {
  Scene scene = small();
  scene.photons = 1000000;
  scene.samples = 1000000;
  RenderOptions options;
  options.time_limit = 0.5;
  const auto backend = make_cpu_backend();
  Renderer renderer(scene, *backend, options);
  EXPECT_FALSE(renderer.run());
  const RenderResult result = renderer.result();
  EXPECT_GT(result.samples.count(), 0u);
  EXPECT_FALSE(result.is_complete);
  // The reported ranges give the same picture.
  ASSERT_EQ(result.photons.list().size(), 1u);
  ASSERT_EQ(result.samples.list().size(), 1u);
  const Partial again = part_of(scene, {result.photons.list()[0], result.samples.list()[0]});
  EXPECT_TRUE(same(develop(again), result));
}

TEST(Parts, whose_first_photons_were_cut_by_the_time_go_on_to_the_same_end) {
  const Scene scene = small();
  const RenderResult whole = render(scene, *make_cpu_backend());
  // As after a time limit: samples read the light of only a part of the first replicate's photons.
  for (const bool keeps_light : {true, false}) {
    RenderOptions options;
    options.photons = IndexRange{0, 20};
    options.samples = IndexRange{0, 1};
    const auto backend = make_cpu_backend();
    Renderer cut(scene, *backend, options);
    ASSERT_TRUE(cut.run());
    Partial left = cut.part();
    ASSERT_EQ(left.samples().text(), "0:1");
    if (keeps_light) {
      options.samples = {};
      Renderer light(scene, *backend, options);
      ASSERT_TRUE(light.run());
      left.replicates[0].light = light.part().replicates[0].light;
    }
    Renderer second(scene, *backend);
    second.resume(left, "checkpoint");
    ASSERT_TRUE(second.run());
    EXPECT_TRUE(same(second.result(), whole)) << keeps_light;
  }
}

/// Counts the photons that it shoots.
class Shooting final : public ForwardingBackend {
 public:
  std::uint64_t shoot(IndexRange photons) override {
    const std::uint64_t end = ForwardingBackend::shoot(photons);
    shot += end - photons.begin;
    return end;
  }
  std::uint64_t shot = 0;
};

TEST(Parts, that_a_limit_of_time_cut_keep_their_photons) {
  const Scene scene = small();
  RenderOptions options;
  options.batch = 20;
  options.time_limit = 1e-9;
  Shooting backend;
  Partial part;
  std::uint64_t before = 0;
  for (int run = 1; run <= 2; ++run) {  // a replicate has 50 photons
    Renderer cut(scene, backend, options);
    if (run > 1) cut.resume(part, "checkpoint");
    EXPECT_FALSE(cut.run());
    part = cut.part();
    EXPECT_EQ(part.photons().count(), before + 20) << run;
    before = part.photons().count();
  }
  EXPECT_GT(part.samples().count(), 0u);
  Renderer last(scene, backend);
  last.resume(part, "checkpoint");
  EXPECT_TRUE(last.run());
  EXPECT_EQ(backend.shot, 400u) << "none of them twice";
  EXPECT_TRUE(same(last.result(), render(scene, *make_cpu_backend())));
}

TEST(Parts, that_a_limit_of_time_ends_are_of_two_replicates) {
  Scene scene = small();
  scene.photons = 100000000;  // too many even for one replicate
  scene.samples = 1000000;
  RenderOptions options;
  options.time_limit = 0.5;
  options.most_lights = most_replicates;
  const auto backend = make_cpu_backend();
  Renderer renderer(scene, *backend, options);
  EXPECT_FALSE(renderer.run());
  const RenderResult result = renderer.result();
  EXPECT_EQ(result.photons.list().size(), 2u) << result.photons.text();
  EXPECT_EQ(result.samples.list().size(), 2u) << result.samples.text();
  EXPECT_EQ(result.replicates, 2);
  EXPECT_NO_THROW(layer(result, "variance"));
  for (const std::string& warning : result.warnings)
    EXPECT_EQ(warning.find("no variance"), std::string::npos);
}

// The time suffices for only a batch of photons and a sample.
TEST(Parts, that_a_limit_of_time_cut_have_photons_of_two_replicates) {
  const Scene scene = small();
  RenderOptions options;
  options.batch = 20;
  options.time_limit = 1e-9;
  options.most_lights = most_replicates;
  Shooting backend;
  Partial part;
  for (int run = 1; run <= 2; ++run) {
    Renderer cut(scene, backend, options);
    if (run > 1) cut.resume(part, "checkpoint");
    EXPECT_FALSE(cut.run());
    part = cut.part();
    EXPECT_EQ(part.replicates[0].photons.count(), 20u * run);
    EXPECT_EQ(part.replicates[1].photons.count(), 20u * run);
    const RenderResult result = cut.result();
    EXPECT_EQ(result.replicates, 1);
    EXPECT_NE(result.warnings.back().find("has no variance; allow more"), std::string::npos)
        << result.warnings.back();
  }
  Renderer last(scene, backend);
  last.resume(part, "checkpoint");
  EXPECT_TRUE(last.run());
  EXPECT_EQ(backend.shot, 400u) << "none of them twice";
  EXPECT_TRUE(same(last.result(), render(scene, *make_cpu_backend())));
}

// Samples of replicates that lack photons are gathered again, and so are those of other replicates.
TEST(Parts, that_were_cut_beside_whole_ones_go_on_to_the_same_end) {
  const Scene scene = small();
  const RenderResult whole = render(scene, *make_cpu_backend());
  const auto backend = make_cpu_backend();
  const auto cut_at = [&](IndexRange photons, IndexRange samples) {
    RenderOptions options;
    options.photons = photons;
    Renderer light(scene, *backend, options);
    EXPECT_TRUE(light.run());
    const Partial lit = light.part();
    options.samples = samples;
    Renderer renderer(scene, *backend, options);
    renderer.resume(lit, "light");
    EXPECT_TRUE(renderer.run());
    Partial part = renderer.part();
    for (std::size_t r = 0; r < part.replicates.size(); ++r)
      part.replicates[r].light = lit.replicates[r].light;
    return part;
  };
  const Partial cut = cut_at({0, 70}, {0, 2});  // 50 photons of the first replicate, 20 of the next
  ASSERT_EQ(cut.samples().count(), 2u);
  Renderer second(scene, *backend);
  second.resume(cut, "checkpoint");
  ASSERT_TRUE(second.run());
  EXPECT_TRUE(same(second.result(), whole));

  Partial lost = cut;  // without light of the first replicate, its samples cannot be redone
  lost.replicates[0].light_hash = light_hash(lost.replicates[0]);
  lost.replicates[0].light = {};
  Renderer third(scene, *backend);
  third.resume(lost, "checkpoint");
  EXPECT_THROW(third.run(), Error);
}

TEST(Parts, of_photons_alone_have_no_preview_before_the_matter_is_read_out) {
  const Scene scene = small();
  const auto backend = make_cpu_backend(2);
  RenderOptions options;
  options.batch = 10;
  options.go_on = [](Renderer& r, Moment moment) {
    return moment != Moment::batch || !r.has_preview();
  };
  Renderer whole(scene, *backend, options);  // the whole medium, and some photons
  EXPECT_FALSE(whole.run());
  Partial part = whole.part();
  options.photons = IndexRange{0, 400};
  bool has_preview = false;
  options.go_on = [&](Renderer& r, Moment) {
    has_preview = has_preview || r.has_preview();
    return true;
  };
  Renderer photons(scene, *backend, options);
  photons.resume(part, "checkpoint");
  EXPECT_TRUE(photons.run());
  EXPECT_FALSE(has_preview);
}

TEST(Parts, without_light_say_nothing_of_samples_under_way) {
  const Scene scene = small();
  const Partial part = part_of(scene, {{}, IndexRange{0, 5}});
  EXPECT_EQ(part.slice.replicate, -1);
  EXPECT_EQ(part.slice.samples.end, 0u);
  EXPECT_EQ(part.slice.pixels, 0u);
}

TEST(Parts, have_the_larger_exposure_in_any_order) {
  Scene scene = small(), brighter = scene;
  brighter.exposure = 3;
  const Partial a = part_of(scene, {{}, IndexRange{0, 5}}),
                b = part_of(brighter, {{}, IndexRange{5, 11}});
  EXPECT_EQ(sum({a, b}).frame.exposure, 3);
  EXPECT_EQ(sum({b, a}).frame.exposure, 3);
}

TEST(Parts, previews_are_the_picture_of_their_ranges) {
  Scene scene = small();
  scene.photons = 40000;  // more than one batch per replicate
  const auto backend = make_cpu_backend(2);
  RenderOptions options;
  options.batch = 1000;
  options.go_on = [](Renderer& r, Moment) { return !r.has_preview(); };
  Renderer renderer(scene, *backend, options);
  EXPECT_FALSE(renderer.run());
  const RenderResult preview = renderer.preview(0.2);
  EXPECT_EQ(preview.photons.text(), "0:1000");
  ASSERT_EQ(preview.samples.list().size(), 1u);
  const Asked ranges{IndexRange{0, 1000}, preview.samples.list()[0]};
  EXPECT_TRUE(same(develop(part_of(scene, ranges)), preview));
}

TEST(Parts, previews_that_no_time_is_left_for_say_that_they_are_none) {
  const Scene scene = small();
  const auto backend = make_cpu_backend(2);
  RenderOptions options;
  options.go_on = [](Renderer& r, Moment) { return !r.has_preview(); };
  Renderer renderer(scene, *backend, options);
  EXPECT_FALSE(renderer.run());
  const RenderResult preview = renderer.preview(0);
  EXPECT_TRUE(preview.samples.empty());
  EXPECT_FALSE(preview.is_complete);
  EXPECT_NE(preview.warnings.back().find("some are black"), std::string::npos);
}

/// Stops in the middle of a batch, and resumes with another renderer.
TEST(Parts, a_pause_ends_a_batch_and_changes_nothing) {
  Scene scene = small();
  scene.photons = 200000;
  const RenderResult whole = render(scene, *make_cpu_backend(2));
  std::atomic<int> asked = 0;
  RenderOptions options;
  options.batch = 1 << 20;  // all in one batch
  std::atomic<bool> has_bounds = false;
  options.progress = [&](const Progress& p) { has_bounds = std::string(p.pass) != "bounds"; };
  options.stop = [&] { return has_bounds && ++asked > 40; };
  options.go_on = [](Renderer&, Moment) { return false; };
  Partial part;
  {
    const auto backend = make_cpu_backend(2);
    Renderer renderer(scene, *backend, options);
    EXPECT_FALSE(renderer.run());
    part = renderer.part();
  }
  EXPECT_TRUE(!part.has(measurement::scattering) || part.photons().count() < scene.photons);
  const auto backend = make_cpu_backend(2);
  Renderer renderer(scene, *backend);
  renderer.resume(std::move(part), "part");
  EXPECT_TRUE(renderer.run());
  EXPECT_TRUE(same(renderer.result(), whole));
}

/// Counts the cells that it measures.
class Measuring final : public ForwardingBackend {
 public:
  std::uint64_t measure(measurement::Id id, IndexRange elements) override {
    const std::uint64_t end = ForwardingBackend::measure(id, elements);
    if (id == measurement::scattering) measured += end - elements.begin;
    return end;
  }
  std::uint64_t measured = 0;
};

TEST(Parts, keep_the_matter_that_was_measured) {
  const Scene scene = small();
  std::uint64_t measured = 0;
  Partial part;
  for (int i = 0; i == 0 || (i < 1000 && !part.is_complete()); ++i) {
    RenderOptions options;
    options.batch = 10;
    options.go_on = [](Renderer&, Moment moment) { return moment == Moment::round; };
    Measuring backend;
    Renderer renderer(scene, backend, options);
    if (i > 0) renderer.resume(part, "part");
    renderer.run();
    part = renderer.part();
    measured += backend.measured;
  }
  EXPECT_TRUE(part.is_complete());
  EXPECT_EQ(measured, 64u);
  EXPECT_TRUE(same(develop(part), render(scene, *make_cpu_backend())));
}

/// Keeps the light taken last, like devices.
class Keeping final : public ForwardingBackend {
 public:
  std::vector<std::int64_t> take_illumination() override {
    return taken_ = ForwardingBackend::take_illumination();
  }
  bool illuminate_with_taken(double photon_power, const std::vector<float>& denominator) override {
    light_.clear();
    for (const std::int64_t sum : taken_) light_.push_back(light_of(sum, photon_power));
    illuminate(light_, denominator);
    ++used;
    return true;
  }
  int used = 0;

 private:
  std::vector<std::int64_t> taken_;
  std::vector<float> light_;  // read by gather()
};

TEST(Parts, are_lit_by_the_light_that_a_device_has_if_that_is_all) {
  const Scene scene = small();
  const RenderResult whole = render(scene, *make_cpu_backend());
  Keeping undisturbed;
  EXPECT_TRUE(same(render(scene, undisturbed), whole));
  EXPECT_EQ(undisturbed.used, 8);

  // part() takes the light within each replicate, so the device has only the rest of it.
  RenderOptions options;
  options.batch = 30;
  options.go_on = [](Renderer& r, Moment) {
    r.part();
    return true;
  };
  Keeping disturbed;
  EXPECT_TRUE(same(render(scene, disturbed, options), whole));
  EXPECT_EQ(disturbed.used, 0);
}

/// The noise that --noise compares, at the end of each replicate of a run.
std::vector<double> noises(const Scene& scene, const Partial& begun) {
  std::vector<double> seen;
  RenderOptions options;
  options.go_on = [&](Renderer& r, Moment moment) {
    if (moment == Moment::round) seen.push_back(relative_noise(r.part()));
    return true;
  };
  const auto backend = make_cpu_backend(2);
  Renderer renderer(scene, *backend, options);
  renderer.resume(begun, "part");
  EXPECT_TRUE(renderer.run());
  return seen;
}

TEST(Parts, are_judged_by_the_same_noise_wherever_they_were_left) {
  Scene scene = small();
  scene.samples = 64;  // 8 per replicate
  Partial nothing, begun;
  {
    const auto backend = make_cpu_backend(2);
    nothing = Renderer(scene, *backend).part();
    RenderOptions options;
    options.samples = {0, 20};  // ends within the third replicate
    options.go_on = [](Renderer& r, Moment) { return r.part().samples().count() < 20; };
    Renderer renderer(scene, *backend, options);
    renderer.run();
    begun = renderer.part();
  }
  const std::vector<double> whole = noises(scene, nothing), rest = noises(scene, begun);
  ASSERT_EQ(whole.size(), 8u);
  EXPECT_EQ(rest, std::vector<double>(whole.begin() + 2, whole.end()));
}

// ---- Limits of noise

/// Renders in turns until is_enough(part).
template <class IsEnough>
RenderResult limited(const Scene& scene, IsEnough&& is_enough) {
  RenderOptions options;
  options.most_lights = most_replicates;
  options.go_on = [&](Renderer& r, Moment moment) {
    return moment != Moment::round || !is_enough(r.part());
  };
  const auto backend = make_cpu_backend(2);
  Renderer renderer(scene, *backend, options);
  renderer.run();
  return renderer.result();
}
RenderResult quiet(const Scene& scene, double limit) {
  return limited(scene, [&](const Partial& part) { return is_noise_below(part, limit); });
}

// A render ends with at most 1.3 times the samples needed for the limit, at any point of the
// render. That number is known from other samples, as noise falls with the square root of their
// number.
TEST(Parts, end_soon_after_the_limit_of_noise) {
  Scene scene = small();
  scene.camera.resolution = {24, 20};
  scene.detectors = {};
  for (const scene::Integrator integrator : {scene::Integrator::path, scene::Integrator::photons}) {
    scene.integrator = integrator;
    scene.photons = 20000;
    scene.samples = 512;
    Scene other = scene;
    other.seed = 99;
    const double noise = render(other, *make_cpu_backend()).noise;
    scene.samples = 100000;
    for (const double samples : {40.0, 150.0, 500.0}) {
      if (integrator == scene::Integrator::photons && samples > 200) continue;  // noise of light
      const double limit = noise * std::sqrt(512 / samples);
      const RenderResult result = quiet(scene, limit);
      EXPECT_LE(result.noise, limit);
      EXPECT_EQ(result.replicates, 8);
      EXPECT_LE(static_cast<double>(result.samples.count()), 1.3 * samples);
      EXPECT_GE(static_cast<double>(result.samples.count()), 0.75 * samples);
    }
  }
}

// The noise of one pixel is uncertain by a third, and repeated checks find the lowest estimate. An
// estimate that is below the limit by chance must not end the render.
TEST(Parts, of_few_pixels_end_by_chance_less_often) {
  Scene scene = small();
  scene.camera.resolution = {1, 1};
  scene.detectors = {};
  scene.integrator = scene::Integrator::path;
  scene.samples = 4096;
  double square = 0;  // of the noise of 4096 samples
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    scene.seed = seed;
    const double one = render(scene, *make_cpu_backend()).noise;
    square += one * one / 20;
  }
  const double samples = 200, limit = std::sqrt(square * 4096 / samples);
  double by_estimate = 0, by_bound = 0;  // variance at the end, divided by the limit's
  for (std::uint64_t seed = 101; seed <= 124; ++seed) {
    scene.seed = seed;
    const auto done = [](const RenderResult& result) {
      return static_cast<double>(result.samples.count());
    };
    by_bound += samples / done(quiet(scene, limit)) / 24;
    by_estimate +=
        samples
        / done(limited(scene, [&](const Partial& part) { return relative_noise(part) <= limit; }))
        / 24;
  }
  EXPECT_LT(by_bound, 1.6);
  EXPECT_GT(by_estimate, 1.5 * by_bound);
}

TEST(Parts, whose_limit_was_reached_end_at_once_when_they_go_on) {
  Scene scene = small();
  scene.samples = 1000;
  RenderOptions options;
  options.most_lights = most_replicates;
  options.go_on = [](Renderer& r, Moment moment) {
    return moment != Moment::round || !is_noise_below(r.part(), 0.2);
  };
  const auto backend = make_cpu_backend(2);
  Renderer first(scene, *backend, options);
  EXPECT_FALSE(first.run());
  const std::uint64_t samples = first.part().samples().count();
  EXPECT_LT(samples, 1000u);
  Renderer second(scene, *backend, options);
  second.resume(first.part(), "checkpoint");
  EXPECT_FALSE(second.run());
  EXPECT_EQ(second.part().samples().count(), samples);
}

TEST(Parts, without_photons_may_be_left_out) {
  const Scene scene = small();  // 8 replicates of 50 photons
  const Partial light =
      sum({part_of(scene, {IndexRange{0, 100}, {}}), part_of(scene, {IndexRange{150, 400}, {}})});
  RenderOptions options;
  options.photons = {0, 0};
  options.samples = {0, 11};
  options.allow_gaps = true;
  const auto backend = make_cpu_backend(2);
  Renderer renderer(scene, *backend, options);
  renderer.resume(light, "light");
  EXPECT_TRUE(renderer.run());
  const Partial& part = renderer.part();
  EXPECT_EQ(part.samples().missing({0, 11}).text(), Ranges({part.frame.samples_of(2)}).text());
  EXPECT_EQ(part.photons().text(), "0:100, 150:400");
  EXPECT_FALSE(renderer.result().is_complete);

  options.samples = part.frame.samples_of(2);  // they have no light
  Renderer dark(scene, *backend, options);
  dark.resume(light, "light");
  EXPECT_THROW(dark.run(), Error);
}

TEST(Parts, photons_that_were_shot_twice_are_told) {
  const Partial a = part_of(small(), {IndexRange{0, 100}, {}});
  EXPECT_EQ(shot_twice(a, a).text(), "0:100");
  EXPECT_TRUE(shot_twice(a, part_of(small(), {IndexRange{100, 200}, {}})).empty());
  const Partial samples = part_of(small(), {{}, IndexRange{0, 2}});
  EXPECT_TRUE(shot_twice(samples, part_of(small(), {{}, IndexRange{2, 4}})).empty());
}

TEST(Parts, without_photons_of_theirs_are_refused) {
  EXPECT_THROW(part_of(small(), {IndexRange{0, 200}, IndexRange{0, 11}}), Error);
}

TEST(Parts, noise_is_that_of_the_picture) {
  Scene scene = small();
  scene.samples = 64;
  scene.photons = 4000;
  // The spread of the luminance of pictures with several seeds.
  const std::vector<RenderResult> results = replicates(scene, 24);
  double told = 0, mean_squares = 0, variances = 0;
  for (const RenderResult& r : results) told += r.noise * r.noise / 24;
  const auto luminance = [](const RenderResult& r, std::size_t i) {
    const float* rgb = &r.picture.rgba[4 * i];
    return 0.2126 * double{rgb[0]} + 0.7152 * double{rgb[1]} + 0.0722 * double{rgb[2]};
  };
  for (std::size_t i = 0; i < 20; ++i) {
    Series s;
    for (const RenderResult& r : results) s.add(luminance(r, i));
    if (!(results[0].picture.rgba[4 * i + 3] > 0)) continue;
    mean_squares += s.mean() * s.mean();
    variances += s.standard_error() * s.standard_error() * 24;
  }
  EXPECT_NEAR(std::sqrt(told), std::sqrt(variances / mean_squares),
              0.25 * std::sqrt(variances / mean_squares));
}

/// Expects that the parts cannot be merged, and that the message has the reason and both names.
void expect_refused(Partial a, Partial b, const std::string& why) {
  try {
    merge(a, "a.tyn", std::move(b), "b.tyn");
    ADD_FAILURE() << "merged; expected: " << why;
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::input_missing);
    const std::string message = error.what();
    EXPECT_NE(message.find(why), std::string::npos) << message;
    EXPECT_EQ(message.find("b.tyn: cannot be merged with a.tyn: "), 0u) << message;
  }
}

TEST(Parts, that_do_not_belong_together_are_refused) {
  const Scene scene = small();
  const Partial whole = part_of(scene, {});
  expect_refused(whole, whole, "both have samples");
  expect_refused(part_of(scene, {IndexRange{0, 200}, {}}),
                 part_of(scene, {IndexRange{120, 300}, {}}), "both have photons");
  Scene other = scene;
  other.seed = 2;
  expect_refused(whole, part_of(other, {}), "its seed is 2, not 1");
  other = scene;
  other.medium.components[0].extinction = 21;
  expect_refused(whole, part_of(other, {}), "another scene");
  Partial older = whole;
  older.frame.arithmetic = 1;
  expect_refused(whole, older, "arithmetic version is 1");
  // Samples of one replicate that read the light of different photons.
  expect_refused(part_of(scene, {IndexRange{350, 360}, IndexRange{9, 10}}),
                 part_of(scene, {IndexRange{360, 400}, IndexRange{10, 11}}),
                 "light of other photons");
}

#if TYNDALL_RAPIDCHECK
/// Cuts [0, n) at up to `most` positions.
std::vector<IndexRange> cut(std::uint64_t n, int most) {
  std::vector<std::uint64_t> at = *rc::gen::container<std::vector<std::uint64_t>>(
      static_cast<std::size_t>(*rc::gen::inRange(0, most + 1)),
      rc::gen::inRange<std::uint64_t>(1, n));
  at.push_back(0), at.push_back(n);
  std::sort(at.begin(), at.end());
  at.erase(std::unique(at.begin(), at.end()), at.end());
  std::vector<IndexRange> ranges;
  for (std::size_t i = 1; i < at.size(); ++i) ranges.push_back({at[i - 1], at[i]});
  for (std::size_t i = ranges.size(); i > 1; --i)
    std::swap(ranges[i - 1], ranges[*rc::gen::inRange<std::size_t>(0, i)]);
  return ranges;
}

TEST(Parts, whose_sizes_are_not_what_their_hash_promises_are_refused) {
  const Partial a = part_of(small(), {{}, IndexRange{0, 4}});
  const Partial b = part_of(small(), {{}, IndexRange{4, 11}});
  const auto expect_refused = [&](const auto& change) {
    Partial sum = a, other = b;
    change(other.frame);
    EXPECT_THROW(merge(sum, "a", other, "b"), Error);
  };
  expect_refused([](Frame& f) { f.width = 6; });
  expect_refused([](Frame& f) { f.replicates = 7; });
  expect_refused([](Frame& f) { f.light_words += 1; });
  expect_refused([](Frame& f) { f.groups.push_back("more"); });
  expect_refused([](Frame& f) { f.detectors.nx = 1; });
}

TEST(Parts, any_split_in_any_order_of_photons_and_of_samples_gives_one_hash) {
  const Scene scene = small();
  const RenderResult whole = render(scene, *make_cpu_backend());
  EXPECT_TRUE(rc::check([&] {
    std::vector<Partial> parts;
    for (const IndexRange& range : cut(400, 4)) parts.push_back(part_of(scene, {range, {}}));
    const Partial light = sum(std::move(parts));
    RC_ASSERT(light.photons().text() == "0:400");
    parts.clear();
    for (const IndexRange& range : cut(11, 4)) parts.push_back(part_of(scene, {{}, range}, &light));
    RC_ASSERT(same(develop(sum(std::move(parts))), whole));
  }));
}
#endif

}  // namespace
}  // namespace tyndall::test
