/// \file
/// A row of the benchmark that runs a sampler on a CUDA device.
#pragma once

#include <chrono>
#include <string>
#include <utility>
#include <vector>

#include "cuda/device.h"
#include "cuda/kernels.cuh"
#include "rows.h"

namespace tyndall::bench {

template <class Sampler>
class CudaRow final : public Row {
 public:
  CudaRow(std::string name, const PreparedScene& scene, Sampler sampler)
      : name_(std::move(name)), scene_(scene), sampler_(sampler) {}

  std::string name() const override { return name_; }
  const std::vector<std::int64_t>& illumination() const override { return sums_; }
  void store_color() override { cells_.channels = 3, cells_.order = 1; }

  Sample run(std::uint64_t begin, std::uint64_t count) override {
    DeviceArrays arrays;
    const auto to_device = [&](const auto* host, std::size_t n) { return arrays.keep(host, n); };
    std::vector<Emitter> emitters = scene_.emitters;
    for (Emitter& emitter : emitters) emitter.relocate(to_device);
    const Lights lights{arrays.keep(emitters.data(), emitters.size()),
                        static_cast<int>(emitters.size())};
    Buffer<std::int64_t> sums(cells_.count() * static_cast<std::size_t>(cells_.moments()));
    Buffer<Account> accounts(account_count);
    AnyMedium copy = scene_.medium;
    std::visit([&](auto& medium) { medium.relocate(to_device); }, copy);
    const auto shoot = [&]<class Medium>(const Medium& medium) {
      const ShootPass<Medium, Sampler> pass{medium,
                                            sampler_,
                                            lights,
                                            scene_.seed,
                                            {cells_, sums.data()},
                                            {accounts.data(), account_count},
                                            {}};
      const IndexRange range{begin, begin + count};
      if constexpr (has_majorants<ShootPass<Medium, Sampler>>)
        run_pass(pass, range, {}, scratch_);
      else
        run_by_indices(pass, range, {}, 1, pace_);
    };
    Sample sample;
    sample.photons = count;
    const auto start = std::chrono::steady_clock::now();
    // The tables have media of these two types only.
    if (const auto* cloud = std::get_if<SingleMedium<NoiseCloud>>(&copy)) shoot(*cloud);
    if (const auto* fog = std::get_if<MixedMedium>(&copy)) shoot(*fog);
    sample.seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    sums_ = sums.read();
    for (const Account& account : accounts.read()) add(sample.account, account);
    return sample;
  }

 private:
  std::string name_;
  const PreparedScene& scene_;
  Sampler sampler_;
  IlluminationCells cells_ = scene_.cells;
  std::vector<std::int64_t> sums_;
  Scratch scratch_;
  Pace pace_{1 << 14, 1 << 28};  // kept between runs, so that launches grow to the largest size
};

}  // namespace tyndall::bench
