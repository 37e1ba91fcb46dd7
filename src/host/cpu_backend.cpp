/// \file
/// The threads of the host. Walks through super-voxels in a box with open sides go side by side in
/// lanes, everything else index by index.
#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "host/lanes.h"
#include "tyndall/render/backend.h"
#include "tyndall/render/huge_pages.h"
#include "tyndall/render/parallel.h"
#include "tyndall/render/prepare.h"
#include "tyndall/render/render.h"
#include "tyndall/transport/depth.h"

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

  void load(const PreparedScene& scene, const Stop& stop) override {
    scene_ = &scene;
    stop_ = stop;
    const std::size_t cells = scene.cells.count();
    illumination_.clear();
    resize_in_huge_pages(illumination_, cells * static_cast<std::size_t>(scene.cells.moments()));
    matter_.assign(cells, 0);
    detectors_.assign(3 * scene.detectors.count(), 0);
    depth_.assign(scene.pixels(), no_depth);
    account_ = {};
    clear_film();
  }

  void shoot(IndexRange photons) override {
    Detectors detectors = scene_->detectors;
    if (!detectors_.empty()) detectors.sums = detectors_.data();
    visit([&]<class Medium, class Sampler>(const Medium& medium, const Sampler& sampler) {
      const ShootPass<Medium, Sampler> pass{
          medium,
          sampler,
          Lights{scene_->emitters.data(), static_cast<int>(scene_->emitters.size())},
          scene_->seed,
          IlluminationTally{scene_->cells, illumination_.data()},
          {nullptr},
          detectors};
      run_walks(photons, pass);
    });
  }

  void measure_matter(IndexRange cells) override {
    std::visit(
        [&]<class Medium>(const Medium& medium) {
          const MatterPass<Medium> pass{
              medium,         scene_->seed,         scene_->cells, scene_->cell_size,
              scene_->strata, scene_->matter_scale, matter_.data()};
          parallel_for(cells.begin, cells.end, 64, threads_,
                       [&](std::uint64_t begin, std::uint64_t end) {
                         run_lanes(pass, begin, end, stop_, instruction_set_);
                       });
        },
        scene_->medium);
  }

  void measure_depth(IndexRange pixels) override {
    std::visit(
        [&]<class Medium>(const Medium& medium) {
          const DepthPass<Medium> pass{medium, scene_->camera, depth_.data()};
          parallel_for(pixels.begin, pixels.end, 64, threads_,
                       [&](std::uint64_t begin, std::uint64_t end) { run(pass, begin, end); });
        },
        scene_->medium);
  }

  std::vector<std::int64_t> take_illumination() override {
    std::vector<std::int64_t> empty;
    resize_in_huge_pages(empty, illumination_.size());
    return std::exchange(illumination_, std::move(empty));
  }
  std::vector<std::int64_t> take_matter() override { return std::exchange(matter_, {}); }
  std::vector<float> take_depth() override { return std::exchange(depth_, {}); }
  std::vector<std::int64_t> take_detectors() override {
    std::vector<std::int64_t> empty(detectors_.size(), 0);
    return std::exchange(detectors_, std::move(empty));
  }
  Account take_account() override { return std::exchange(account_, {}); }

  void illuminate(const std::vector<float>& numerator,
                  const std::vector<float>& denominator) override {
    field_ = {scene_->cells, numerator.empty() ? nullptr : numerator.data(), denominator.data()};
  }

  void gather(IndexRange pixels, SampleRange samples) override {
    visit([&]<class Medium, class Sampler>(const Medium& medium, const Sampler& sampler) {
      run_walks(
          {pixels.begin * samples.count, pixels.end * samples.count},
          GatherPass<Medium, Sampler>{
              medium,
              sampler,
              scene_->camera,
              field_,
              DirectLights{scene_->direct_lights.data(),
                           static_cast<int>(scene_->direct_lights.size())},
              scene_->background,
              scene_->bounces,
              scene_->is_apart,
              scene_->seed,
              samples,
              Film{scene_->film_width, scene_->film_height, scene_->film_unit, film_.pixels.data(),
                   &film_.clamped, film_.groups.empty() ? nullptr : film_.groups.data(),
                   static_cast<int>(scene_->groups.size())},
              {nullptr},
              scene_->bright_pixels.empty() ? nullptr : scene_->bright_pixels.data()});
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

  /// The medium's and the sampler's types are chosen here, once a launch.
  template <class Launch>
  void visit(Launch&& launch) {
    std::visit(launch, scene_->medium, scene_->sampler);
  }

  /// Calls a pass of walks for every index.
  template <class Pass>
  void run_walks(IndexRange range, const Pass& pass) {
    const bool by_lanes = has_lanes(pass);
    // Long chunks: the lanes of a chunk's last paths run half empty.
    const std::uint64_t share =
        (range.end - range.begin) / (4 * static_cast<std::uint64_t>(threads_));
    parallel_for(range.begin, range.end,
                 by_lanes ? std::clamp<std::uint64_t>(share, 2048, 65536) : 64, threads_,
                 [&](std::uint64_t begin, std::uint64_t end) {
                   Account account;  // a chunk's own, lest the threads fight over one
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
  Stop stop_;
  std::vector<std::int64_t> illumination_, matter_, detectors_;
  std::vector<float> depth_;
  Account account_;
  IlluminationField field_;
  FilmTallies film_;
};

}  // namespace

std::unique_ptr<Backend> make_cpu_backend(int threads, const std::string& instruction_set) {
  return std::make_unique<CpuBackend>(threads, instruction_set);
}

}  // namespace tyndall
