/// \file
/// The CPU backend: the threads of the host. Walks through super-voxels in a box with open sides
/// run in SIMD lanes; everything else runs index by index.
#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "host/lanes.h"
#include "tyndall/render/backend.h"
#include "tyndall/render/huge_pages.h"
#include "tyndall/render/measurement_pass.h"
#include "tyndall/render/parallel.h"
#include "tyndall/render/prepare.h"
#include "tyndall/render/render.h"

namespace tyndall {
namespace {

class CpuBackend final : public Backend {
 public:
  CpuBackend(int threads, std::string instruction_set)
      : threads_(thread_count(threads)), instruction_set_(std::move(instruction_set)) {}

  std::string name() const override {
    return fmt::format("cpu, {} thread{}", threads_, threads_ == 1 ? "" : "s");
  }
  int threads() const override { return threads_; }
  double table_points() const override { return NoiseTable::processor_points; }

  void load(const PreparedScene& scene, const Stop& stop, const Stop& pause) override {
    scene_ = &scene;
    stop_ = stop;
    pause_ = pause;
    illumination_.clear();
    resize_in_huge_pages(illumination_,
                         scene.cells.count() * static_cast<std::size_t>(scene.cells.moments()));
    measured_ = {};
    detectors_.assign(3 * scene.detectors.count(), 0);
    account_ = {};
    clear_film();
  }

  std::uint64_t shoot(IndexRange photons) override {
    Detectors detectors = scene_->detectors;
    if (!detectors_.empty()) detectors.sums = detectors_.data();
    return visit([&]<class Medium, class Sampler>(const Medium& medium, const Sampler& sampler) {
      const ShootPass<Medium, Sampler> pass{
          .medium = medium,
          .sampler = sampler,
          .lights = scene_->lights(),
          .seed = scene_->seed,
          .illumination = {scene_->cells, illumination_.data()},
          .accounts = {},
          .detectors = detectors,
      };
      return run_walks(photons, pass);
    });
  }

  std::uint64_t measure(measurement::Id id, IndexRange elements) override {
    std::vector<std::int64_t>& words = measured_[id];
    words.resize(measurement::word_count(id, *scene_));
    const auto run_pass = [&](const auto& pass) {
      return parallel_for_until(
          pause_, elements.begin, elements.end, 64, threads_,
          [&](std::uint64_t begin, std::uint64_t end) { run(pass, begin, end); });
    };
    return std::visit(
        [&](const auto& medium) {
          return measurement::run_pass_of(id, *scene_, medium, scene_->cells, scene_->camera,
                                          words.data(), run_pass);
        },
        scene_->medium);
  }

  std::vector<std::int64_t> take_illumination() override {
    std::vector<std::int64_t> empty;
    resize_in_huge_pages(empty, illumination_.size());
    return std::exchange(illumination_, std::move(empty));
  }
  // Measurements are usually taken once, so their memory is given away.
  std::vector<std::int64_t> take(measurement::Id id) override {
    measured_[id].resize(measurement::word_count(id, *scene_));
    return std::exchange(measured_[id], {});
  }
  std::vector<std::int64_t> take_detectors() override {
    std::vector<std::int64_t> empty(detectors_.size(), 0);
    return std::exchange(detectors_, std::move(empty));
  }
  Account take_account() override { return std::exchange(account_, {}); }

  void illuminate(const std::vector<float>& numerator,
                  const std::vector<float>& denominator) override {
    field_ = {scene_->cells, numerator.empty() ? nullptr : numerator.data(), denominator.data()};
  }

  std::uint64_t gather(IndexRange pixels, SampleRange samples) override {
    return visit([&]<class Medium, class Sampler>(const Medium& medium, const Sampler& sampler) {
      const GatherPass<Medium, Sampler> pass{
          .medium = medium,
          .sampler = sampler,
          .camera = scene_->camera,
          .illumination = field_,
          .lights = {scene_->direct_lights.data(), static_cast<int>(scene_->direct_lights.size())},
          .background = scene_->background,
          .bounces = scene_->bounces,
          .is_apart = scene_->is_apart,
          .seed = scene_->gather_seed,
          .samples = samples,
          .film = scene_->film(film_.pixels.data(), &film_.clamped, film_.groups.data()),
          .accounts = {},
          .pixels = scene_->bright_pixels.empty() ? nullptr : scene_->bright_pixels.data(),
      };
      return run_walks({pixels.begin * samples.count, pixels.end * samples.count}, pass,
                       samples.count)
             / samples.count;
    });
  }

  FilmTallies take_film() override {
    FilmTallies film = std::move(film_);
    clear_film();
    return film;
  }

 private:
  void clear_film() {
    film_ = {};
    film_.pixels.resize(scene_->pixels());
    film_.groups.resize(scene_->pixels() * scene_->groups.size() * 3);
  }

  /// Selects the types of the medium and of the sampler, once per launch.
  template <class Launch>
  std::uint64_t visit(Launch&& launch) {
    return std::visit(launch, scene_->medium, scene_->sampler);
  }

  /// Calls a pass of walks for every index. Groups of `together` indices are done as a whole or not
  /// at all.
  template <class Pass>
  std::uint64_t run_walks(IndexRange range, const Pass& pass, std::uint64_t together = 1) {
    const bool by_lanes = has_lanes(pass);
    const std::uint64_t chunk =
        (chunk_length(range, by_lanes) + together - 1) / together * together;
    return parallel_for_until(pause_, range.begin, range.end, chunk, threads_,
                              [&](std::uint64_t begin, std::uint64_t end) {
                                Account account;  // one per chunk, to avoid contention
                                Pass own = pass;
                                own.accounts = {&account};
                                if (by_lanes) {
                                  run_side_by_side(own, begin, end);
                                } else {
                                  run(own, begin, end);
                                }
                                add(account_, account);
                              });
  }

  /// Lanes need long chunks: they are half empty during the last paths of a chunk. But a pause
  /// waits for the end of a chunk, and each thread needs one.
  std::uint64_t chunk_length(IndexRange range, bool by_lanes) const {
    constexpr std::uint64_t least = 2048, most = 16384;
    if (!by_lanes) return 64;
    const std::uint64_t each = (range.end - range.begin) / static_cast<std::uint64_t>(threads_) + 1;
    return std::clamp(each / 4, std::min(each, least), most);
  }

  template <class Medium, template <class, class> class Pass>
  static bool has_lanes(const Pass<Medium, SuperVoxel>& pass) {
    const Box& box = pass.medium.whole.box;
    return !box.periodic_x && !box.periodic_y && !box.periodic_z;
  }
  template <class Pass>
  static bool has_lanes(const Pass&) {
    return false;
  }

  template <class Medium, template <class, class> class Pass>
  void run_side_by_side(const Pass<Medium, SuperVoxel>& pass, std::uint64_t begin,
                        std::uint64_t end) const {
    run_lanes(pass, begin, end, stop_, instruction_set_);
  }
  template <class Pass>
  void run_side_by_side(const Pass&, std::uint64_t, std::uint64_t) const {}

  template <class Medium>
  void run(const MatterPass<Medium>& pass, std::uint64_t begin, std::uint64_t end) const {
    run_lanes(pass, begin, end, stop_, instruction_set_);
  }
  template <class Pass>
  void run(const Pass& pass, std::uint64_t begin, std::uint64_t end) const {
    for (std::uint64_t index = begin; index < end; ++index) {
      stop_if(stop_);
      pass(index);
    }
  }

  int threads_;
  std::string instruction_set_;
  const PreparedScene* scene_ = nullptr;
  Stop stop_, pause_;
  std::vector<std::int64_t> illumination_, detectors_;
  measurement::Each<std::vector<std::int64_t>> measured_;
  Account account_;
  IlluminationField field_;
  FilmTallies film_;
};

}  // namespace

std::unique_ptr<Backend> make_cpu_backend(int threads, const std::string& instruction_set) {
  return std::make_unique<CpuBackend>(threads, instruction_set);
}

}  // namespace tyndall
