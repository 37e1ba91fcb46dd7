/// \file
/// The CUDA backend: one device, with copies of the data of the passes, and their tallies.
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "device.h"
#include "run_pass.h"
#include "schedule.h"
#include "tyndall/render/backend.h"
#include "tyndall/render/error.h"
#include "tyndall/render/measurement_pass.h"
#include "tyndall/render/parallel.h"
#include "tyndall/render/prepare.h"
#include "tyndall/render/render.h"
#include "tyndall/transport/lane.h"

namespace tyndall {
namespace {

/// Converts the sums to light on the device, without a copy through the host.
__global__ void read_out(const std::int64_t* sums, std::size_t count, double photon_power,
                         float* light) {
  const std::size_t step = std::size_t{gridDim.x} * blockDim.x;
  for (std::size_t i = std::size_t{blockIdx.x} * blockDim.x + threadIdx.x; i < count; i += step)
    light[i] = light_of(sums[i], photon_power);
}

class CudaBackend final : public Backend {
 public:
  explicit CudaBackend(int device) : device_(device) {
    int count = 0;
    const cudaError_t status = cudaGetDeviceCount(&count);
    if (status != cudaSuccess) {
      throw Error(ExitCode::device,
                  "no usable CUDA device (" + problem(status) + "); use --device cpu");
    }
    if (device < 0 || device >= count) {
      throw Error(ExitCode::device, "no CUDA device " + std::to_string(device)
                                        + ": this machine has " + std::to_string(count)
                                        + "; use --device cpu");
    }
    select();
    cudaDeviceProp properties;
    require(cudaGetDeviceProperties(&properties, device), "asking for the device's properties");
    name_ = std::string("cuda, ") + properties.name;
    most_lanes_ = static_cast<std::size_t>(properties.multiProcessorCount)
                  * static_cast<std::size_t>(properties.maxThreadsPerMultiProcessor);
    require_kernels();
  }

  std::string name() const override { return name_; }
  int threads() const override { return thread_count(0); }
  double table_points() const override { return NoiseTable::device_points; }
  // A run ends with its longest path, alone, for up to 50 ms. Few long runs are best.
  std::uint64_t first_batch() const override { return Schedule::most_waiting; }
  double batch_seconds() const override { return 1.0; }

  void load(const PreparedScene& scene, const Stop& stop, const Stop& pause) override {
    select();
    scene_ = &scene;
    interrupts_ = {stop, pause};
    arrays_.clear();
    medium_ = scene.medium;
    const auto to_device = [&](const auto* host, std::size_t count) {
      return arrays_.keep(host, count);
    };
    std::visit([&](auto& medium) { medium.relocate(to_device); }, medium_);
    std::vector<Emitter> emitters = scene.emitters;
    for (Emitter& emitter : emitters) emitter.relocate(to_device);
    camera_ = scene.camera;
    camera_.relocate(to_device);
    lights_ = {
        arrays_.keep(emitters.data(), emitters.size()), static_cast<int>(emitters.size()),
        scene.clumps.empty() ? nullptr : arrays_.keep(scene.clumps.data(), scene.clumps.size()),
        static_cast<int>(scene.clumps.size())};
    cells_ = scene.cells;
    cells_.bricks.relocate(to_device);
    std::vector<DirectLight> direct = scene.direct_lights;
    for (DirectLight& light : direct) relocate(light.light, to_device);
    direct_lights_ = {arrays_.keep(direct.data(), direct.size()), static_cast<int>(direct.size())};
    const std::vector<std::uint32_t>& bright = scene.bright_pixels;
    bright_pixels_ = bright.empty() ? nullptr : arrays_.keep(bright.data(), bright.size());
    const std::size_t words = scene.cells.count() * static_cast<std::size_t>(scene.cells.moments());
    illumination_.renew(words);
    is_taken_ = false;
    // Allocated now, not after the photons, so that a lack of memory is found before the work.
    numerator_.renew(scene.has_grid ? words : 0);
    denominator_.renew(scene.has_grid ? scene.cells.count() : 0);
    for (const measurement::Id id : measurement::ids)
      measured_[id].renew(measurement::word_count(id, scene));
    detectors_.renew(3 * scene.detectors.count());
    accounts_.renew(account_count);
    pixels_.renew(scene.pixels());
    groups_.renew(scene.pixels() * scene.groups.size() * 3);
    clamped_.renew(1);
    visit([&]<class Medium, class Sampler>(const Medium&, const Sampler&) -> std::uint64_t {
      using Pass = GatherPass<Medium, Sampler>;  // larger than those of photons
      scratch_.paths.room<Begun<Pass>>(Schedule::most_waiting);
      scratch_.lanes.room<typename Lane<Pass>::Saved>(most_lanes_);
      return 0;
    });
  }

  std::uint64_t shoot(IndexRange photons) override {
    select();
    forget_taken();
    Detectors detectors = scene_->detectors;
    if (detectors_.size() > 0) detectors.sums = detectors_.data();
    return visit([&]<class Medium, class Sampler>(const Medium& medium, const Sampler& sampler) {
      const ShootPass<Medium, Sampler> pass{
          .medium = medium,
          .sampler = sampler,
          .lights = lights_,
          .seed = scene_->seed,
          .illumination = {cells_, illumination_.data()},
          .accounts = accounts(),
          .detectors = detectors,
      };
      return run_pass(pass, photons, interrupts_, scratch_);
    });
  }

  std::uint64_t measure(measurement::Id id, IndexRange elements) override {
    select();
    return std::visit(
        [&](const auto& medium) {
          return measurement::run_pass_of(
              id, *scene_, medium, cells_, camera_, measured_[id].data(),
              [&](const auto& pass) { return run_pass(pass, elements, interrupts_, scratch_); });
        },
        medium_);
  }

  /// Keeps the sums on the device for illuminate_with_taken().
  std::vector<std::int64_t> take_illumination() override {
    select();
    forget_taken();
    is_taken_ = true;
    return illumination_.read();
  }
  std::vector<std::int64_t> take(measurement::Id id) override { return take(measured_[id]); }
  std::vector<std::int64_t> take_detectors() override { return take(detectors_); }

  Account take_account() override {
    Account sum;
    for (const Account& account : take(accounts_)) add(sum, account);
    return sum;
  }

  void illuminate(const std::vector<float>& numerator,
                  const std::vector<float>& denominator) override {
    select();
    if (!numerator.empty()) numerator_.write(numerator.data());
    if (!denominator.empty()) denominator_.write(denominator.data());
    field_ = {cells_, numerator.empty() ? nullptr : numerator_.data(), denominator_.data()};
  }

  bool illuminate_with_taken(double photon_power, const std::vector<float>& denominator) override {
    if (!is_taken_) return false;
    select();
    constexpr unsigned blocks = 1024, threads = 256;
    read_out<<<blocks, threads>>>(illumination_.data(), illumination_.size(), photon_power,
                                  numerator_.data());
    require(cudaGetLastError(), "launching a kernel");
    denominator_.write(denominator.data());
    field_ = {cells_, numerator_.data(), denominator_.data()};
    return true;
  }

  std::uint64_t gather(IndexRange pixels, SampleRange samples) override {
    select();
    return visit([&]<class Medium, class Sampler>(const Medium& medium, const Sampler& sampler) {
      const GatherPass<Medium, Sampler> pass{
          .medium = medium,
          .sampler = sampler,
          .camera = camera_,
          .illumination = field_,
          .lights = direct_lights_,
          .background = scene_->background,
          .bounces = scene_->bounces,
          .is_apart = scene_->is_apart,
          .seed = scene_->gather_seed,
          .samples = samples,
          .film = scene_->film(pixels_.data(), clamped_.data(), groups_.data()),
          .accounts = accounts(),
          .pixels = bright_pixels_,
      };
      const IndexRange paths{pixels.begin * samples.count, pixels.end * samples.count};
      return run_pass(pass, paths, interrupts_, scratch_, samples.count) / samples.count;
    });
  }

  FilmTallies take_film() override { return {take(pixels_), take(groups_), take(clamped_)[0]}; }

 private:
  /// The current device is per host thread. A new thread has the default device.
  void select() const {
    require(cudaSetDevice(device_), "selecting device " + std::to_string(device_));
  }

  Accounts accounts() const { return {accounts_.data(), account_count}; }

  template <class T>
  std::vector<T> take(Buffer<T>& buffer) const {
    select();
    std::vector<T> values = buffer.read();
    buffer.clear();
    return values;
  }

  void forget_taken() {
    if (std::exchange(is_taken_, false)) illumination_.clear();
  }

  template <class Launch>
  std::uint64_t visit(Launch&& launch_with) {
    return std::visit(launch_with, medium_, scene_->sampler);
  }

  const int device_;
  std::string name_;
  std::size_t most_lanes_ = 0;  // resident at the same time
  const PreparedScene* scene_ = nullptr;
  Interrupts interrupts_;
  AnyMedium medium_;  // its arrays on the device
  Camera camera_;     // its arrays on the device
  Lights lights_;
  IlluminationCells cells_;
  DirectLights direct_lights_;
  IlluminationField field_;
  const std::uint32_t* bright_pixels_ = nullptr;
  DeviceArrays arrays_;
  Buffer<std::int64_t> illumination_, detectors_, clamped_, groups_;
  measurement::Each<Buffer<std::int64_t>> measured_;
  Buffer<float> numerator_, denominator_;
  Buffer<Account> accounts_;
  Buffer<PixelTally> pixels_;
  Scratch scratch_;
  bool is_taken_ = false;  // illumination_ was taken, and must be cleared before the next photons
};

}  // namespace

std::unique_ptr<Backend> make_cuda_backend(int device) {
  return std::make_unique<CudaBackend>(device);
}

}  // namespace tyndall
