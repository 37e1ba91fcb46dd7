#include "support/chandrasekhar.h"

#include <cmath>
#include <numbers>

namespace tyndall::test {
namespace {

constexpr double pi = std::numbers::pi;

}  // namespace

GaussLegendre::GaussLegendre(int n) {
  for (int i = 1; i <= n; ++i) {
    double z = std::cos(pi * (i - 0.25) / (n + 0.5)), slope = 1;
    for (int newton = 0; newton < 20; ++newton) {
      double p = 1, before = 0;
      for (int k = 1; k <= n; ++k) {
        const double next = ((2 * k - 1) * z * p - (k - 1) * before) / k;
        before = p;
        p = next;
      }
      slope = n * (z * p - before) / (z * z - 1);
      z -= p / slope;
    }
    nodes.push_back((1 - z) / 2);
    weights.push_back(1 / ((1 - z * z) * slope * slope));
  }
}

IsotropicSlab::IsotropicSlab(double optical_thickness, double albedo, std::vector<double> cosines,
                             int streams)
    : albedo_(albedo), streams_(static_cast<std::size_t>(streams)) {
  const GaussLegendre rule(streams);
  cosines_ = rule.nodes;
  cosines_.insert(cosines_.end(), cosines.begin(), cosines.end());
  const std::size_t n = cosines_.size();

  // dX/dt = Y s, dY/dt = X s - Y / mu, with s = albedo / 2 times the integral of Y / mu over mu, by
  // the classic Runge-Kutta method. The smallest mu sets the step.
  using State = std::vector<double>;  // X, then Y
  const auto slope = [&](const State& state, State& out) {
    double s = 0;
    for (std::size_t i = 0; i < streams_; ++i)
      s += albedo / 2 * rule.weights[i] / cosines_[i] * state[n + i];
    for (std::size_t i = 0; i < n; ++i) {
      out[i] = state[n + i] * s;
      out[n + i] = state[i] * s - state[n + i] / cosines_[i];
    }
  };
  State state(2 * n, 1.0), moved(2 * n), k1(2 * n), k2(2 * n), k3(2 * n), k4(2 * n);
  const auto move = [&](const State& k, double step) {
    for (std::size_t i = 0; i < 2 * n; ++i) moved[i] = state[i] + step * k[i];
  };
  const int steps = static_cast<int>(std::ceil(optical_thickness / (0.25 * rule.nodes[0])));
  const double h = optical_thickness / steps;
  for (int step = 0; step < steps; ++step) {
    slope(state, k1);
    move(k1, h / 2);
    slope(moved, k2);
    move(k2, h / 2);
    slope(moved, k3);
    move(k3, h);
    slope(moved, k4);
    for (std::size_t i = 0; i < 2 * n; ++i)
      state[i] += h / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i]);
  }
  x_.assign(state.begin(), state.begin() + static_cast<std::ptrdiff_t>(n));
  y_.assign(state.begin() + static_cast<std::ptrdiff_t>(n), state.end());
  mean_x_ = mean_y_ = 0;
  for (std::size_t i = 0; i < streams_; ++i) {
    mean_x_ += rule.weights[i] * x_[i];
    mean_y_ += rule.weights[i] * y_[i];
  }
}

double IsotropicSlab::reflectance(int beam) const {
  return 1 - x(beam) * (1 - albedo_ / 2 * mean_x_) - y(beam) * albedo_ / 2 * mean_y_;
}

double IsotropicSlab::transmittance(int beam) const {
  return y(beam) * (1 - albedo_ / 2 * mean_x_) + x(beam) * albedo_ / 2 * mean_y_;
}

double IsotropicSlab::reflected(int beam, int view) const {
  const double in = cosines_[place(beam)], out = cosines_[place(view)];
  return albedo_ / (4 * pi) * in / (out + in) * (x(view) * x(beam) - y(view) * y(beam));
}

double IsotropicSlab::transmitted(int beam, int view) const {
  const double in = cosines_[place(beam)], out = cosines_[place(view)];
  return albedo_ / (4 * pi) * in / (out - in) * (y(view) * x(beam) - x(view) * y(beam));
}

HFunction::HFunction(double albedo, int streams)
    : albedo_(albedo), rule_(streams), values_(rule_.nodes.size(), 1.0) {
  for (int iteration = 0; iteration < 400; ++iteration) {
    std::vector<double> next;
    for (const double cosine : rule_.nodes) next.push_back((*this)(cosine));
    values_ = next;
  }
}

double HFunction::operator()(double cosine) const {
  double integral = 0;
  for (std::size_t i = 0; i < values_.size(); ++i)
    integral += rule_.weights[i] * rule_.nodes[i] * values_[i] / (cosine + rule_.nodes[i]);
  return 1 / (std::sqrt(1 - albedo_) + albedo_ / 2 * integral);
}

PointSource::PointSource(double albedo) {
  // The discrete rate: albedo atanh(k) = k.
  double low = 0, high = 1;
  for (int bisection = 0; bisection < 200; ++bisection) {
    const double k = (low + high) / 2;
    (albedo * std::atanh(k) < k ? low : high) = k;
  }
  const double k2 = low * low;
  sum_.push_back({k2 * (1 - k2) / (2 * pi * albedo * (k2 - (1 - albedo))), low});
  // Rates 1 + x up to infinity; the trapezoidal rule in t converges fast with x = exp(t - exp(-t)).
  const double step = 0.1;
  for (double t = -4; t < 12; t += step) {
    const double x = std::exp(t - std::exp(-t)), s = 1 + x;
    const double real = 1 - albedo / (2 * s) * std::log((2 + x) / x);
    const double imaginary = pi * albedo / (2 * s);
    const double weight = 1 / (4 * pi * (real * real + imaginary * imaginary));
    sum_.push_back({weight * x * (1 + std::exp(-t)) * step, s});
  }
}

double PointSource::fluence(double distance) const {
  double sum = 0;
  for (const Exponential& e : sum_) sum += e.weight * std::exp(-e.rate * distance);
  return sum / distance;
}

double PointSource::fluence_around_ball(double radius, double distance) const {
  double sum = 0;
  for (const Exponential& e : sum_) {
    // exp(-s r) 3 (a cosh a - sinh a) / a^3 with a = s radius, without its overflow
    const double a = e.rate * radius;
    const double within = std::exp(-e.rate * (distance - radius)) * 1.5
                          * ((a - 1) + (a + 1) * std::exp(-2 * a)) / (a * a * a);
    sum += e.weight * within;
  }
  return sum / distance;
}

double PointSource::moment(int power) const {
  double sum = 0;
  for (const Exponential& e : sum_) {
    const double square = 1 / (e.rate * e.rate);
    sum += 4 * pi * e.weight * (power == 0 ? square : 6 * square * square);
  }
  return sum;
}

}  // namespace tyndall::test
