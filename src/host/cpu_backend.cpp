/// \file
/// The threads of the host: every pass called index by index, but for photons in a single noise
/// cloud, which fly side by side in lanes.
#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "host/lanes.h"
#include "tyndall/render/backend.h"
#include "tyndall/render/parallel.h"
#include "tyndall/render/prepare.h"
#include "tyndall/render/render.h"

namespace tyndall {
namespace {

bool is_open(const Box& box) { return !box.periodic_x && !box.periodic_y && !box.periodic_z; }

class CpuBackend final : public Backend {
 public:
  explicit CpuBackend(int threads) : threads_(thread_count(threads)) {}

  std::string name() const override {
    return fmt::format("cpu, {} thread{}", threads_, threads_ == 1 ? "" : "s");
  }
  int threads() const override { return threads_; }

  void load(const PreparedScene& scene, const Stop& stop) override {
    scene_ = &scene;
    stop_ = stop;
    const std::size_t cells = scene.cells.count();
    illumination_.assign(cells * static_cast<std::size_t>(scene.cells.moments()), 0);
    matter_.assign(cells, 0);
    account_ = {};
    film_ = {};
  }

  void shoot(IndexRange photons) override {
    visit([&]<class Medium, class Sampler>(const Medium& medium, const Sampler& sampler) {
      const ShootPass<Medium, Sampler> pass{
          medium,
          sampler,
          Lights{scene_->emitters.data(), static_cast<int>(scene_->emitters.size())},
          scene_->seed,
          IlluminationTally{scene_->cells, illumination_.data()},
          nullptr};
      if constexpr (requires { shoot_lanes(pass, 0, 0, stop_); }) {
        if (is_open(medium.whole.box)) return run_lanes(photons, pass);
      }
      run(photons, 64, [&](Account* account) {
        ShootPass<Medium, Sampler> own = pass;
        own.account = account;
        return own;
      });
    });
  }

  void measure_matter(IndexRange cells) override {
    std::visit(
        [&]<class Medium>(const Medium& medium) {
          run(cells, 64, [&](Account*) {
            return MatterPass<Medium>{medium,
                                      scene_->seed,
                                      {scene_->cells, illumination_.data()},
                                      scene_->cell_size,
                                      scene_->strata,
                                      scene_->matter_scale,
                                      matter_.data()};
          });
        },
        scene_->medium);
  }

  std::vector<std::int64_t> take_illumination() override {
    return std::exchange(illumination_, {});
  }
  std::vector<std::int64_t> take_matter() override { return std::exchange(matter_, {}); }
  Account take_account() override { return std::exchange(account_, {}); }

  void illuminate(const std::vector<float>& numerator,
                  const std::vector<float>& denominator) override {
    field_ = {scene_->cells, numerator.data(), denominator.data()};
    film_.pixels.assign(static_cast<std::size_t>(scene_->film_width)
                            * static_cast<std::size_t>(scene_->film_height),
                        {});
  }

  void gather(IndexRange samples) override {
    visit([&]<class Medium, class Sampler>(const Medium& medium, const Sampler& sampler) {
      run(samples, 256, [&](Account* account) {
        return GatherPass<Medium, Sampler>{
            medium,
            sampler,
            scene_->camera,
            field_,
            scene_->background,
            scene_->seed,
            Film{scene_->film_width, scene_->film_height, scene_->film_unit, film_.pixels.data(),
                 &film_.clamped},
            account};
      });
    });
  }

  FilmTallies take_film() override { return std::exchange(film_, {}); }

 private:
  /// The medium's and the sampler's types are chosen here, once a launch.
  template <class Launch>
  void visit(Launch&& launch) {
    std::visit(launch, scene_->medium, scene_->sampler);
  }

  /// Calls the pass for every index; each chunk keeps its own account, lest the threads fight over
  /// one.
  template <class MakePass>
  void run(IndexRange range, std::uint64_t grain, const MakePass& make_pass) {
    parallel_for(range.begin, range.end, grain, threads_,
                 [&](std::uint64_t begin, std::uint64_t end) {
                   Account account;
                   const auto pass = make_pass(&account);
                   for (std::uint64_t index = begin; index < end; ++index) {
                     stop_if(stop_);
                     pass(index);
                   }
                   add(account_, account);
                 });
  }

  /// Long chunks: the lanes of a chunk's last photons run half empty.
  template <class Pass>
  void run_lanes(IndexRange photons, const Pass& pass) {
    const std::uint64_t share =
        (photons.end - photons.begin) / (4 * static_cast<std::uint64_t>(threads_));
    parallel_for(photons.begin, photons.end, std::clamp<std::uint64_t>(share, 2048, 65536),
                 threads_, [&](std::uint64_t begin, std::uint64_t end) {
                   Account account;
                   Pass own = pass;
                   own.account = &account;
                   shoot_lanes(own, begin, end, stop_);
                   add(account_, account);
                 });
  }

  int threads_;
  const PreparedScene* scene_ = nullptr;
  Stop stop_;
  std::vector<std::int64_t> illumination_, matter_;
  Account account_;
  IlluminationField field_;
  FilmTallies film_;
};

}  // namespace

std::unique_ptr<Backend> make_cpu_backend(int threads) {
  return std::make_unique<CpuBackend>(threads);
}

}  // namespace tyndall
