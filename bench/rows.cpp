#include "rows.h"

#include <algorithm>
#include <chrono>

#include "cuda_rows.h"
#include "samplers.h"
#include "tyndall/render/parallel.h"
#include "tyndall/render/render.h"

namespace tyndall::bench {
namespace {

/// Runs a sampler in the reference pass, one photon after the other.
template <class Sampler>
class ReferenceRow final : public Row {
 public:
  ReferenceRow(std::string name, const PreparedScene& scene, Sampler sampler, int threads)
      : name_(std::move(name)), scene_(scene), sampler_(sampler), threads_(threads) {}

  std::string name() const override { return name_; }
  const std::vector<std::int64_t>& illumination() const override { return sums_; }
  void store_color() override { cells_.channels = 3, cells_.order = 1; }

  Sample run(std::uint64_t begin, std::uint64_t count) override {
    sums_.assign(cells_.count() * static_cast<std::size_t>(cells_.moments()), 0);
    Sample sample;
    sample.photons = count;
    const Lights lights{scene_.emitters.data(), static_cast<int>(scene_.emitters.size())};
    const auto start = std::chrono::steady_clock::now();
    std::visit(
        [&]<class Medium>(const Medium& medium) {
          parallel_for(
              begin, begin + count, 64, threads_, [&](std::uint64_t first, std::uint64_t last) {
                Account account;
                const ShootPass<Medium, Sampler> pass{
                    medium, sampler_, lights, scene_.seed, {cells_, sums_.data()}, {&account}};
                for (std::uint64_t i = first; i < last; ++i) pass(i);
                add(sample.account, account);
              });
        },
        scene_.medium);
    sample.seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return sample;
  }

 private:
  std::string name_;
  const PreparedScene& scene_;
  Sampler sampler_;
  int threads_;
  IlluminationCells cells_ = scene_.cells;
  std::vector<std::int64_t> sums_;
};

/// Shoots photons as `tyndall render` does.
class BackendRow final : public Row {
 public:
  BackendRow(std::string name, Stage& stage, std::unique_ptr<Backend> backend)
      : name_(std::move(name)), stage_(stage), backend_(std::move(backend)) {}

  std::string name() const override { return name_; }
  const std::vector<std::int64_t>& illumination() const override { return sums_; }
  void store_color() override { colored_ = true; }

  Sample run(std::uint64_t begin, std::uint64_t count) override {
    PreparedScene& scene = stage_.usual;
    const IlluminationCells cells = scene.cells;
    if (colored_) scene.cells.channels = 3, scene.cells.order = 1;
    backend_->load(scene, {});
    Sample sample;
    sample.photons = count;
    const auto start = std::chrono::steady_clock::now();
    backend_->shoot({begin, begin + count});
    sample.seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    sums_ = backend_->take_illumination();
    sample.account = backend_->take_account();
    scene.cells = cells;
    return sample;
  }

 private:
  std::string name_;
  Stage& stage_;
  std::unique_ptr<Backend> backend_;
  bool colored_ = false;
  std::vector<std::int64_t> sums_;
};

Path first_path(const Stage& stage, std::uint64_t index, std::uint64_t seed) {
  const PreparedScene& scene = stage.scene16;
  const RandomStream random{seed, index, Domain::photon};
  const RandomBlock first = random.block(0, Purpose::emission);
  const Lights lights{scene.emitters.data(), static_cast<int>(scene.emitters.size())};
  const Box box = std::visit([](const auto& m) { return m.whole.box; }, scene.medium);
  Path path{
      emit(lights, box, first, random.block(0, Purpose::aim)).ray, exponential(first.d), 0, {}};
  enter(box, path.ray);
  return path;
}

bool has_wider_lanes_than_avx2() {
  const std::vector<std::string> sets = instruction_sets();
  return sets.front() != "v3" && std::find(sets.begin(), sets.end(), "v3") != sets.end();
}

template <class Sampler>
std::vector<FirstFlight> fly(const Stage& stage, const PreparedScene& scene, const Sampler& sampler,
                             std::uint64_t count, std::uint64_t seed) {
  std::vector<FirstFlight> flights(count);
  std::visit(
      [&](const auto& medium) {
        parallel_for(0, count, 16, stage.threads, [&](std::uint64_t begin, std::uint64_t end) {
          Audit audit;
          for (std::uint64_t i = begin; i < end; ++i) {
            Path path = first_path(stage, i, seed);
            const Vec3f from = path.ray.origin;
            const Flight flight =
                sampler.fly(medium, path, RandomStream{seed, i, Domain::photon}, audit);
            flights[i] = {flight.end == Flight::End::collided,
                          double{length(path.ray.origin - from)}};
          }
        });
      },
      scene.medium);
  return flights;
}

}  // namespace

float finest_voxel(const Case& which) {
  return 1.0f / static_cast<float>(which.effective_resolution());
}

Stage::Stage(const Case& c, int t, const std::string& device)
    : which(c),
      threads(t),
      scene16(prepare_case(c, 16, t)),
      scene32(prepare_case(c, 32, t)),
      scene64(prepare_case(c, 64, t)),
      usual(prepare_case(
          c, 0, t, device == "cpu" ? NoiseTable::processor_points : NoiseTable::device_points)) {}

std::vector<std::unique_ptr<Row>> rows_of(Stage& stage, const std::string& device) {
  std::vector<std::unique_ptr<Row>> rows;
  if (device != "cpu") {
#if TYNDALL_CUDA
    rows = published_cuda_rows(stage);
    rows.push_back(fast_math_cuda_row(stage));
    rows.push_back(std::make_unique<BackendRow>("tyndall", stage, make_cuda_backend()));
#endif
    return rows;
  }
  const auto add_row = [&](const char* name, const PreparedScene& scene, auto sampler) {
    rows.push_back(
        std::make_unique<ReferenceRow<decltype(sampler)>>(name, scene, sampler, stage.threads));
  };
  add_row("ray_marching", stage.scene16, RayMarching{finest_voxel(stage.which)});
  add_row("woodcock", stage.scene16, Woodcock2011{});
  add_row("woodcock_squeezed", stage.scene16, Woodcock{});
  add_row("super_voxel_2011", stage.scene16, SuperVoxel2011{});
  add_row("super_voxel_2011/32", stage.scene32, SuperVoxel2011{});
  add_row("super_voxel_2011/64", stage.scene64, SuperVoxel2011{});
  rows.push_back(reference_of_render(stage));
  if (has_wider_lanes_than_avx2())
    rows.push_back(
        std::make_unique<BackendRow>("tyndall/avx2", stage, make_cpu_backend(stage.threads, "v3")));
  rows.push_back(std::make_unique<BackendRow>("tyndall", stage, make_cpu_backend(stage.threads)));
  return rows;
}

std::unique_ptr<Row> reference_of_render(const Stage& stage) {
  return std::make_unique<ReferenceRow<SuperVoxel>>("super_voxel_squeezed", stage.usual,
                                                    SuperVoxel{}, stage.threads);
}

std::vector<FirstFlight> first_flights(const Stage& stage, const std::string& row,
                                       std::uint64_t count, std::uint64_t seed) {
  if (row == "ray_marching")
    return fly(stage, stage.scene16, RayMarching{finest_voxel(stage.which)}, count, seed);
  if (row == "woodcock") return fly(stage, stage.scene16, Woodcock2011{}, count, seed);
  if (row == "woodcock_squeezed") return fly(stage, stage.scene16, Woodcock{}, count, seed);
  if (row == "super_voxel_2011") return fly(stage, stage.scene16, SuperVoxel2011{}, count, seed);
  if (row == "super_voxel_2011/32") return fly(stage, stage.scene32, SuperVoxel2011{}, count, seed);
  if (row == "super_voxel_2011/64") return fly(stage, stage.scene64, SuperVoxel2011{}, count, seed);
  return fly(stage, stage.usual, SuperVoxel{}, count, seed);
}

double marched_depth(const Stage& stage, std::uint64_t index, std::uint64_t seed, int refine,
                     double most) {
  return std::visit(
      [&](const auto& medium) {
        const Path path = first_path(stage, index, seed);
        SuperVoxelWalk walk(medium.whole, path.ray);
        const float step = finest_voxel(stage.which) / static_cast<float>(refine);
        double depth = 0;
        for (double left = most;;) {
          const float length = min(step, walk.length_to_exit());
          const Vec3f middle = walk.position() + 0.5f * length * walk.direction();
          depth += double{total_sigma_t(medium, middle)} * std::min(left, double{length});
          left -= double{length};
          if (length < step || left <= 0) return depth;
          walk.advance(length);
        }
      },
      stage.scene16.medium);
}

}  // namespace tyndall::bench
