/// \file
/// A CPU backend for tests that override some of its functions.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tyndall/render/render.h"

namespace tyndall::test {

class ForwardingBackend : public Backend {
 public:
  std::string name() const override { return cpu_->name(); }
  int threads() const override { return cpu_->threads(); }
  double table_points() const override { return cpu_->table_points(); }
  void load(const PreparedScene& scene, const Stop& stop, const Stop& pause) override {
    cpu_->load(scene, stop, pause);
  }
  std::uint64_t shoot(IndexRange photons) override { return cpu_->shoot(photons); }
  std::uint64_t measure(measurement::Id id, IndexRange elements) override {
    return cpu_->measure(id, elements);
  }
  std::uint64_t gather(IndexRange pixels, SampleRange samples) override {
    return cpu_->gather(pixels, samples);
  }
  std::vector<std::int64_t> take(measurement::Id id) override { return cpu_->take(id); }
  std::vector<std::int64_t> take_illumination() override { return cpu_->take_illumination(); }
  std::vector<std::int64_t> take_detectors() override { return cpu_->take_detectors(); }
  Account take_account() override { return cpu_->take_account(); }
  FilmTallies take_film() override { return cpu_->take_film(); }
  void illuminate(const std::vector<float>& numerator,
                  const std::vector<float>& denominator) override {
    cpu_->illuminate(numerator, denominator);
  }

 private:
  std::unique_ptr<Backend> cpu_ = make_cpu_backend();
};

}  // namespace tyndall::test
