#include "support/bias.h"

#include <cmath>

namespace tyndall::test {
namespace {

/// Sums over the replicates, place by place, also with one replicate left out.
class Sums {
 public:
  explicit Sums(const Replicates& all)
      : all_(&all), sum_(all[0].size(), 0.0), squares_(all[0].size(), 0.0) {
    for (const std::vector<double>& one : all) {
      for (std::size_t p = 0; p < one.size(); ++p) {
        sum_[p] += one[p];
        squares_[p] += one[p] * one[p];
      }
    }
  }

  std::size_t count() const { return all_->size(); }
  std::size_t places() const { return sum_.size(); }

  struct Moments {
    double mean, variance;  ///< the variance of that mean
  };
  /// \param without the replicate to leave out; count(): none
  Moments at(std::size_t place, std::size_t without) const {
    const double left_out = without < count() ? (*all_)[without][place] : 0;
    const double n = static_cast<double>(count()) - (without < count() ? 1 : 0);
    const double sum = sum_[place] - left_out, squares = squares_[place] - left_out * left_out;
    return {sum / n, n > 1 ? (squares - sum * sum / n) / (n * (n - 1)) : 0};
  }

 private:
  const Replicates* all_;
  std::vector<double> sum_, squares_;
};

struct Differences {
  double mean = 0, square = 0;
};

Differences differences(const Sums& pictures, const Sums& truth, std::size_t without_picture,
                        std::size_t without_truth) {
  Differences d;
  const auto count = static_cast<double>(truth.places());
  for (std::size_t p = 0; p < truth.places(); ++p) {
    const Sums::Moments a = pictures.at(p, without_picture), b = truth.at(p, without_truth);
    d.mean += (a.mean - b.mean) / count;
    d.square += ((a.mean - b.mean) * (a.mean - b.mean) - a.variance - b.variance) / count;
  }
  return d;
}

/// \return the jackknife's variance of an estimate; without(i) leaves out replicate i of n.
template <class Without>
Differences jackknife(std::size_t n, const Without& without) {
  Differences variance;
  if (n < 2) return variance;
  std::vector<Differences> all;
  Differences center;
  for (std::size_t i = 0; i < n; ++i) {
    all.push_back(without(i));
    center.mean += all[i].mean / static_cast<double>(n);
    center.square += all[i].square / static_cast<double>(n);
  }
  const double share = static_cast<double>(n - 1) / static_cast<double>(n);
  for (const Differences& d : all) {
    variance.mean += share * (d.mean - center.mean) * (d.mean - center.mean);
    variance.square += share * (d.square - center.square) * (d.square - center.square);
  }
  return variance;
}

}  // namespace

Bias bias(const Replicates& pictures, const Replicates& truth) {
  const Sums a(pictures), b(truth);
  double radiance = 0;
  for (std::size_t p = 0; p < b.places(); ++p)
    radiance += b.at(p, b.count()).mean / static_cast<double>(b.places());
  const Differences all = differences(a, b, a.count(), b.count());
  const Differences of_pictures = jackknife(
                        a.count(), [&](std::size_t i) { return differences(a, b, i, b.count()); }),
                    of_truth = jackknife(
                        b.count(), [&](std::size_t i) { return differences(a, b, a.count(), i); });
  const double scale = 1 / radiance;
  return {
      {all.mean * scale, std::sqrt(of_pictures.mean + of_truth.mean) * scale},
      {all.square * scale * scale, std::sqrt(of_pictures.square + of_truth.square) * scale * scale},
      std::sqrt(of_pictures.mean) * scale,
      std::sqrt(of_truth.mean) * scale};
}

}  // namespace tyndall::test
