/// \file
/// The CUDA backend: buffers, copies, launches. One thread per photon, cell or pixel sample; the
/// physics is the text of tyndall/transport, which the host compiles too.
#include <cuda_runtime.h>

#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "tyndall/render/backend.h"
#include "tyndall/render/error.h"
#include "tyndall/render/parallel.h"
#include "tyndall/render/prepare.h"
#include "tyndall/render/render.h"
#include "tyndall/transport/depth.h"

namespace tyndall {
namespace {

void require(cudaError_t status, const std::string& what) {
  if (status != cudaSuccess) {
    throw Error(ExitCode::device,
                "CUDA: " + what + " failed (" + cudaGetErrorString(status) + "); try --device cpu");
  }
}

/// Device memory that holds `count` values.
template <class T>
class Buffer {
 public:
  static_assert(std::is_trivially_copyable_v<T>);

  Buffer() = default;
  Buffer(const T* host, std::size_t count) : count_(count) {
    allocate();
    require(cudaMemcpy(data_.get(), host, bytes(), cudaMemcpyHostToDevice),
            "copying to the device");
  }
  explicit Buffer(std::size_t count) : count_(count) {
    allocate();
    clear();
  }

  T* data() const { return static_cast<T*>(data_.get()); }
  std::size_t size() const { return count_; }
  void clear() { require(cudaMemset(data_.get(), 0, bytes()), "clearing device memory"); }

  /// Waits for the kernels before it.
  std::vector<T> read() const {
    std::vector<T> host(count_);
    require(cudaMemcpy(host.data(), data_.get(), bytes(), cudaMemcpyDeviceToHost),
            "copying from the device");
    return host;
  }

 private:
  struct Free {
    void operator()(void* p) const { cudaFree(p); }
  };
  std::size_t bytes() const { return count_ * sizeof(T); }
  void allocate() {
    void* p = nullptr;
    require(cudaMalloc(&p, bytes() > 0 ? bytes() : 1),
            "allocating " + std::to_string(bytes()) + " bytes");
    data_.reset(p);
  }

  std::size_t count_ = 0;
  std::unique_ptr<void, Free> data_;
};

template <class Pass>
__global__ void run_pass(Pass pass, std::uint64_t begin, std::uint64_t end) {
  const std::uint64_t index = begin + std::uint64_t{blockIdx.x} * blockDim.x + threadIdx.x;
  if (index < end) pass(index);
}

template <class Pass>
void launch(const Pass& pass, IndexRange range, const Stop& stop) {
  constexpr std::uint64_t block = 128, most = std::uint64_t{1} << 24;
  for (std::uint64_t begin = range.begin; begin < range.end; begin += most) {
    stop_if(stop);
    const std::uint64_t end = begin + most < range.end ? begin + most : range.end;
    run_pass<<<static_cast<unsigned>((end - begin + block - 1) / block),
               static_cast<unsigned>(block)>>>(pass, begin, end);
    require(cudaGetLastError(), "launching a kernel");
  }
  require(cudaDeviceSynchronize(), "running a kernel");
}

class CudaBackend final : public Backend {
 public:
  explicit CudaBackend(int device) {
    int count = 0;
    const cudaError_t status = cudaGetDeviceCount(&count);
    if (status != cudaSuccess) {
      throw Error(ExitCode::device, std::string("no usable CUDA device (")
                                        + cudaGetErrorString(status) + "); use --device cpu");
    }
    if (device < 0 || device >= count) {
      throw Error(ExitCode::device, "no CUDA device " + std::to_string(device)
                                        + ": this machine has " + std::to_string(count)
                                        + "; use --device cpu");
    }
    require(cudaSetDevice(device), "selecting device " + std::to_string(device));
    cudaDeviceProp properties;
    require(cudaGetDeviceProperties(&properties, device), "asking for the device's properties");
    name_ = std::string("cuda, ") + properties.name;
  }

  std::string name() const override { return name_; }
  int threads() const override { return thread_count(0); }

  void load(const PreparedScene& scene, const Stop& stop) override {
    scene_ = &scene;
    stop_ = stop;
    arrays_.clear();
    medium_ = scene.medium;
    const auto to_device = [&](const auto* host, std::size_t count) { return keep(host, count); };
    std::visit([&](auto& medium) { medium.relocate(to_device); }, medium_);
    std::vector<Emitter> emitters = scene.emitters;
    for (Emitter& emitter : emitters) emitter.relocate(to_device);
    camera_ = scene.camera;
    camera_.relocate(to_device);
    lights_ = {keep(emitters.data(), emitters.size()), static_cast<int>(emitters.size())};
    std::vector<DirectLight> direct = scene.direct_lights;
    for (DirectLight& light : direct) light.sky.relocate(to_device);
    direct_lights_ = {keep(direct.data(), direct.size()), static_cast<int>(direct.size())};
    const std::vector<std::uint32_t>& bright = scene.bright_pixels;
    bright_pixels_ = bright.empty() ? nullptr : keep(bright.data(), bright.size());
    illumination_ =
        Buffer<std::int64_t>(scene.cells.count() * static_cast<std::size_t>(scene.cells.moments()));
    matter_ = Buffer<std::int64_t>(scene.cells.count());
    detectors_ = Buffer<std::int64_t>(3 * scene.detectors.count());
    depth_ = Buffer<float>(scene.pixels());
    account_ = Buffer<Account>(1);
    pixels_ = Buffer<PixelTally>(scene.pixels());
    groups_ = Buffer<std::int64_t>(scene.pixels() * scene.groups.size() * 3);
    clamped_ = Buffer<std::int64_t>(1);
  }

  void shoot(IndexRange photons) override {
    Detectors detectors = scene_->detectors;
    if (detectors_.size() > 0) detectors.sums = detectors_.data();
    visit([&]<class Medium, class Sampler>(const Medium& medium, const Sampler& sampler) {
      launch(ShootPass<Medium, Sampler>{medium, sampler, lights_, scene_->seed,
                                        IlluminationTally{scene_->cells, illumination_.data()},
                                        account_.data(), detectors},
             photons, stop_);
    });
  }

  void measure_matter(IndexRange cells) override {
    std::visit(
        [&]<class Medium>(const Medium& medium) {
          launch(MatterPass<Medium>{medium, scene_->seed, scene_->cells, scene_->cell_size,
                                    scene_->strata, scene_->matter_scale, matter_.data()},
                 cells, stop_);
        },
        medium_);
  }

  void measure_depth(IndexRange pixels) override {
    std::visit(
        [&]<class Medium>(const Medium& medium) {
          launch(DepthPass<Medium>{medium, camera_, depth_.data()}, pixels, stop_);
        },
        medium_);
  }

  std::vector<std::int64_t> take_illumination() override { return take(illumination_); }
  std::vector<std::int64_t> take_matter() override { return std::exchange(matter_, {}).read(); }
  std::vector<float> take_depth() override { return std::exchange(depth_, {}).read(); }
  std::vector<std::int64_t> take_detectors() override { return take(detectors_); }

  Account take_account() override { return take(account_)[0]; }

  void illuminate(const std::vector<float>& numerator,
                  const std::vector<float>& denominator) override {
    numerator_ = Buffer<float>(numerator.data(), numerator.size());
    denominator_ = Buffer<float>(denominator.data(), denominator.size());
    field_ = {scene_->cells, numerator.empty() ? nullptr : numerator_.data(), denominator_.data()};
  }

  void gather(IndexRange pixels, SampleRange samples) override {
    visit([&]<class Medium, class Sampler>(const Medium& medium, const Sampler& sampler) {
      launch(
          GatherPass<Medium, Sampler>{
              medium, sampler, camera_, field_, direct_lights_, scene_->background, scene_->bounces,
              scene_->is_apart, scene_->seed, samples,
              Film{scene_->film_width, scene_->film_height, scene_->film_unit, pixels_.data(),
                   clamped_.data(), scene_->groups.empty() ? nullptr : groups_.data(),
                   static_cast<int>(scene_->groups.size())},
              account_.data(), bright_pixels_},
          {pixels.begin * samples.count, pixels.end * samples.count}, stop_);
    });
  }

  FilmTallies take_film() override { return {take(pixels_), take(groups_), take(clamped_)[0]}; }

 private:
  template <class T>
  static std::vector<T> take(Buffer<T>& buffer) {
    std::vector<T> values = buffer.read();
    buffer.clear();
    return values;
  }

  template <class Launch>
  void visit(Launch&& launch_with) {
    std::visit(launch_with, medium_, scene_->sampler);
  }

  /// \return a copy of the array on the device, which lives until the next load().
  template <class T>
  const T* keep(const T* host, std::size_t count) {
    auto buffer = std::make_shared<Buffer<T>>(host, count);
    arrays_.push_back(buffer);
    return buffer->data();
  }

  std::string name_;
  const PreparedScene* scene_ = nullptr;
  Stop stop_;
  AnyMedium medium_;  // its arrays on the device
  Camera camera_;     // the same
  Lights lights_;
  DirectLights direct_lights_;
  IlluminationField field_;
  const std::uint32_t* bright_pixels_ = nullptr;
  std::vector<std::shared_ptr<void>> arrays_;
  Buffer<std::int64_t> illumination_, matter_, detectors_, clamped_, groups_;
  Buffer<float> numerator_, denominator_, depth_;
  Buffer<Account> account_;
  Buffer<PixelTally> pixels_;
};

}  // namespace

CudaDevices cuda_devices() {
  CudaDevices devices;
  int count = 0;
  if (const cudaError_t status = cudaGetDeviceCount(&count); status != cudaSuccess) {
    devices.problem = cudaGetErrorString(status);
    return devices;
  }
  for (int device = 0; device < count; ++device) {
    cudaDeviceProp p;
    require(cudaGetDeviceProperties(&p, device), "asking for the device's properties");
    devices.names.push_back(std::string(p.name) + ", " + std::to_string(p.totalGlobalMem >> 20)
                            + " MiB, sm_" + std::to_string(10 * p.major + p.minor));
  }
  if (devices.names.empty()) devices.problem = "no device";
  return devices;
}

std::unique_ptr<Backend> make_cuda_backend(int device) {
  return std::make_unique<CudaBackend>(device);
}

}  // namespace tyndall
