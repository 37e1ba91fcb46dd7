#include "support/adding_doubling.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "support/chandrasekhar.h"

namespace tyndall::test {
namespace {

constexpr double pi = std::numbers::pi;
// Weight of the nodes outside the quadrature, views and the beam: practically 0, but the operators'
// columns can be divided by it.
constexpr double no_weight = 1e-9;

std::vector<double> legendre(double x, std::size_t count) {
  std::vector<double> p(count, 1.0);
  if (count > 1) p[1] = x;
  for (std::size_t l = 2; l < count; ++l) {
    const auto n = static_cast<double>(l);
    p[l] = ((2 * n - 1) * x * p[l - 1] - (n - 1) * p[l - 2]) / n;
  }
  return p;
}

using Matrix = std::vector<double>;

Matrix product(const Matrix& a, const Matrix& b, std::size_t n) {
  Matrix c(n * n, 0.0);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t k = 0; k < n; ++k) {
      const double value = a[i * n + k];
      for (std::size_t j = 0; j < n; ++j) c[i * n + j] += value * b[k * n + j];
    }
  return c;
}

/// (1 - a)^-1 b, by elimination; `b` has `columns` columns.
Matrix solve(Matrix a, Matrix b, std::size_t n, std::size_t columns) {
  for (double& x : a) x = -x;
  for (std::size_t i = 0; i < n; ++i) a[i * n + i] += 1;
  for (std::size_t k = 0; k < n; ++k) {
    std::size_t pivot = k;
    for (std::size_t i = k + 1; i < n; ++i)
      if (std::abs(a[i * n + k]) > std::abs(a[pivot * n + k])) pivot = i;
    if (pivot != k) {
      std::swap_ranges(&a[k * n], &a[k * n] + n, &a[pivot * n]);
      std::swap_ranges(&b[k * columns], &b[k * columns] + columns, &b[pivot * columns]);
    }
    for (std::size_t i = k + 1; i < n; ++i) {
      const double factor = a[i * n + k] / a[k * n + k];
      if (factor == 0) continue;
      for (std::size_t j = k; j < n; ++j) a[i * n + j] -= factor * a[k * n + j];
      for (std::size_t j = 0; j < columns; ++j) b[i * columns + j] -= factor * b[k * columns + j];
    }
  }
  for (std::size_t k = n; k-- > 0;) {
    for (std::size_t j = 0; j < columns; ++j) {
      double& x = b[k * columns + j];
      for (std::size_t i = k + 1; i < n; ++i) x -= a[k * n + i] * b[i * columns + j];
      x /= a[k * n + k];
    }
  }
  return b;
}

}  // namespace

std::vector<double> henyey_greenstein_moments(double g, int count) {
  std::vector<double> moments;
  for (double chi = 1; static_cast<int>(moments.size()) < count; chi *= g) moments.push_back(chi);
  return moments;
}

std::vector<double> moments_of(const std::function<double(double)>& phase, int count, int nodes) {
  const GaussLegendre rule(nodes);
  std::vector<double> moments(static_cast<std::size_t>(count), 0.0);
  for (std::size_t i = 0; i < rule.nodes.size(); ++i) {
    const double cosine = 2 * rule.nodes[i] - 1, value = phase(cosine) * rule.weights[i];
    const std::vector<double> p = legendre(cosine, moments.size());
    for (std::size_t l = 0; l < moments.size(); ++l) moments[l] += value * p[l];
  }
  const double total = moments[0];
  for (double& chi : moments) chi /= total;
  return moments;
}

SlabReference::SlabReference(double optical_thickness, double albedo, std::vector<double> moments,
                             std::vector<double> cosines, int streams)
    : thickness_(optical_thickness), albedo_(albedo), moments_(std::move(moments)) {
  moments_.resize(std::min(moments_.size(), static_cast<std::size_t>(2 * streams)));
  const GaussLegendre rule(streams);
  cosines_ = rule.nodes;
  weights_ = rule.weights;
  cosines.push_back(1);
  for (const double cosine : cosines) {
    cosines_.push_back(cosine);
    weights_.push_back(no_weight);
  }
  size_ = cosines_.size();
  whole_ = layer(thickness_);
}

double SlabReference::kernel(double to, double from) const {
  const std::vector<double> a = legendre(to, moments_.size()), b = legendre(from, moments_.size());
  double sum = 0;
  for (std::size_t l = 0; l < moments_.size(); ++l)
    sum += (2 * static_cast<double>(l) + 1) * moments_[l] * a[l] * b[l];
  return sum;
}

SlabReference::Layer SlabReference::layer(double optical_thickness) const {
  // Begins with a layer thin enough for single scattering, then doubles its thickness.
  int doublings = 0;
  double thin = optical_thickness;
  while (thin > 1e-8) thin /= 2, ++doublings;
  Layer l{Matrix(size_ * size_), Matrix(size_ * size_)};
  std::vector<std::vector<double>> p;
  for (const double cosine : cosines_) p.push_back(legendre(cosine, moments_.size()));
  for (std::size_t i = 0; i < size_; ++i) {
    for (std::size_t j = 0; j < size_; ++j) {
      double same = 0, other = 0;
      for (std::size_t k = 0; k < moments_.size(); ++k) {
        const double term = (2 * static_cast<double>(k) + 1) * moments_[k] * p[i][k] * p[j][k];
        same += term;
        other += k % 2 == 0 ? term : -term;
      }
      const double scale = albedo_ * thin / (2 * cosines_[i]) * weights_[j];
      l.reflection[i * size_ + j] = scale * other;
      l.transmission[i * size_ + j] = scale * same + (i == j ? std::exp(-thin / cosines_[i]) : 0.0);
    }
  }
  for (; doublings > 0; --doublings) {
    // T (1 - R R)^-1 T and R + T (1 - R R)^-1 R T
    Matrix both(2 * size_ * size_);
    const Matrix rt = product(l.reflection, l.transmission, size_);
    for (std::size_t i = 0; i < size_; ++i) {
      std::copy_n(&l.transmission[i * size_], size_, &both[2 * i * size_]);
      std::copy_n(&rt[i * size_], size_, &both[(2 * i + 1) * size_]);
    }
    both = solve(product(l.reflection, l.reflection, size_), std::move(both), size_, 2 * size_);
    Matrix down(size_ * size_), up(size_ * size_);
    for (std::size_t i = 0; i < size_; ++i) {
      std::copy_n(&both[2 * i * size_], size_, &down[i * size_]);
      std::copy_n(&both[(2 * i + 1) * size_], size_, &up[i * size_]);
    }
    const Matrix reflected = product(l.transmission, up, size_);
    l.transmission = product(l.transmission, down, size_);
    for (std::size_t i = 0; i < reflected.size(); ++i) l.reflection[i] += reflected[i];
  }
  return l;
}

std::size_t SlabReference::node(int view) const {
  if (view < 0) return size_ - 1;
  return size_ - 1
         - (weights_.size()
            - static_cast<std::size_t>(std::find(weights_.begin(), weights_.end(), no_weight)
                                       - weights_.begin())
            - 1)
         + static_cast<std::size_t>(view);
}

double SlabReference::reflected(int view) const {
  return whole_.reflection[node(view) * size_ + size_ - 1] / (2 * pi * no_weight);
}

double SlabReference::transmitted(int view) const {
  const std::size_t i = node(view);
  const double beam = i == size_ - 1 ? std::exp(-thickness_) : 0.0;
  return (whole_.transmission[i * size_ + size_ - 1] - beam) / (2 * pi * no_weight);
}

double SlabReference::reflectance() const {
  double sum = 0;
  for (std::size_t i = 0; weights_[i] != no_weight; ++i)
    sum += weights_[i] * cosines_[i] * whole_.reflection[i * size_ + size_ - 1] / no_weight;
  return sum;
}

double SlabReference::transmittance() const {
  double sum = std::exp(-thickness_);
  for (std::size_t i = 0; weights_[i] != no_weight; ++i)
    sum += weights_[i] * cosines_[i] * whole_.transmission[i * size_ + size_ - 1] / no_weight;
  return sum;
}

double SlabReference::scattered(double depth, double cosine, int order) const {
  return scattered(depth, std::vector<double>{cosine}, order)[0];
}

std::vector<double> SlabReference::scattered(double depth, const std::vector<double>& cosines,
                                             int order) const {
  const Layer above = layer(depth), below = layer(thickness_ - depth);
  // Downwards (1 - R R')^-1 T, upwards R' times that.
  Matrix column(size_);
  for (std::size_t i = 0; i < size_; ++i)
    column[i] = above.transmission[i * size_ + size_ - 1] / (2 * pi * no_weight);
  const Matrix down = solve(product(above.reflection, below.reflection, size_), column, size_, 1);
  std::vector<double> sums(cosines.size(), 0.0);
  for (std::size_t j = 0; j < size_; ++j) {
    double up = 0;
    for (std::size_t k = 0; k < size_; ++k) up += below.reflection[j * size_ + k] * down[k];
    double light = down[j];
    if (j == size_ - 1 && order > 0) light -= std::exp(-depth) / (2 * pi * no_weight);
    for (std::size_t i = 0; i < cosines.size(); ++i) {
      sums[i] +=
          weights_[j] / 2
          * (kernel(cosines[i], cosines_[j]) * light + kernel(cosines[i], -cosines_[j]) * up);
    }
  }
  return sums;
}

}  // namespace tyndall::test
