#include "render/noise_samples.h"

#include <cmath>
#include <utility>

namespace tyndall {
namespace {

double fade(double t) { return t * t * t * (t * (t * 6 - 15) + 10); }
double lerp(double a, double b, double t) { return a + t * (b - a); }

/// Calls at(sample, near, far) for all samples along `axis`; near and far are the results of
/// fill(lattice line) for the two lattice lines next to the sample. Each line is filled once.
/// \pre samples are less than a cell apart
template <class Axis, class Slice, class Fill, class At>
void sweep(const Axis& axis, int samples, Slice& a, Slice& b, Fill&& fill, At&& at) {
  Slice *near = &a, *far = &b;
  fill(axis.cell[0], *far);
  for (int i = 0; i < samples; ++i) {
    if (i == 0 || axis.cell[i] != axis.cell[i - 1]) {
      std::swap(near, far);
      fill(axis.cell[i] + 1, *far);
    }
    at(i, *near, *far);
  }
}

}  // namespace

/// An axis of a grid of samples, in the lattice of an octave.
struct NoiseSamples::Axis {
  // For each sample: its cell of the lattice, its position in the cell, and fade(position).
  int cell[most_boxes + 1];
  double place[most_boxes + 1], weight[most_boxes + 1];

  Axis(const std::vector<double>& at, double frequency) {
    for (std::size_t i = 0; i < at.size(); ++i) {
      const double p = frequency * at[i], line = std::floor(p);
      cell[i] = static_cast<int>(line);
      place[i] = p - line;
      weight[i] = fade(place[i]);
    }
  }
};

/// Noise at (y, z) near the lattice line (y0, z0): value + slope_y (y - y0) + slope_z (z - z0).
struct NoiseSamples::Line {
  double value[most_boxes + 1], slope_y[most_boxes + 1], slope_z[most_boxes + 1];

  void fill(const Axis& x, int samples, std::uint32_t hash_yz) {
    for (int i = 0; i < samples; ++i) {
      const std::uint32_t hash_x = static_cast<std::uint32_t>(x.cell[i]) * lattice_x;
      const std::uint32_t near = lattice_hash(hash_x ^ hash_yz),
                          far = lattice_hash((hash_x + lattice_x) ^ hash_yz);
      const double u = x.place[i], w = x.weight[i];
      value[i] = lerp(u * gradient_dot(near, 1, 0, 0), (u - 1) * gradient_dot(far, 1, 0, 0), w);
      slope_y[i] = lerp(double{gradient_dot(near, 0, 1, 0)}, double{gradient_dot(far, 0, 1, 0)}, w);
      slope_z[i] = lerp(double{gradient_dot(near, 0, 0, 1)}, double{gradient_dot(far, 0, 0, 1)}, w);
    }
  }
};
NoiseSamples::NoiseSamples(glm::dvec3 low, glm::dvec3 step, int n)
    : side_(n + 1), plane_(side_ * side_), sums_(static_cast<std::size_t>(plane_) * side_) {
  for (int axis = 0; axis < 3; ++axis) {
    at_[axis].resize(side_);
    for (int i = 0; i <= n; ++i) at_[axis][i] = low[axis] + step[axis] * i;
  }
  for (Plane* p : {&a_, &b_}) p->value.resize(plane_), p->slope_z.resize(plane_);
}

double NoiseSamples::add_octaves(const NoiseCloud& f, glm::dvec3 edge) {
  bool sampled = true;
  double slack = 0.0, amplitude = 1.0, frequency = 2.0;
  for (int k = 1; k <= f.octaves; ++k, amplitude *= f.gain, frequency *= 2.0) {
    const double curvature =
        noise_second_derivative / 8.0 * frequency * frequency * glm::dot(edge, edge);
    sampled = sampled && curvature < noise_bound;
    if (sampled) add_octave(frequency, amplitude, octave_seed(f.seed, k));
    slack += amplitude * (sampled ? curvature + noise_rounding : double{noise_bound});
  }
  return slack;
}

void NoiseSamples::add_octave(double frequency, double amplitude, std::uint32_t seed) {
  const Axis x(at_[0], frequency), y(at_[1], frequency), z(at_[2], frequency);
  const auto fill_plane = [&](int line_z, Plane& plane) {
    const std::uint32_t hash_z = static_cast<std::uint32_t>(line_z) * lattice_z ^ seed;
    const auto fill_line = [&](int line_y, Line& line) {
      line.fill(x, side_, static_cast<std::uint32_t>(line_y) * lattice_y ^ hash_z);
    };
    Line a, b;
    sweep(y, side_, a, b, fill_line, [&](int j, const Line& near, const Line& far) {
      const double v = y.place[j], w = y.weight[j];
      double *value = &plane.value[j * side_], *slope_z = &plane.slope_z[j * side_];
      for (int i = 0; i < side_; ++i) {
        value[i] =
            lerp(near.value[i] + v * near.slope_y[i], far.value[i] + (v - 1) * far.slope_y[i], w);
        slope_z[i] = lerp(near.slope_z[i], far.slope_z[i], w);
      }
    });
  };
  sweep(z, side_, a_, b_, fill_plane, [&](int k, const Plane& near, const Plane& far) {
    const double v = z.place[k], w = z.weight[k];
    double* sum = &sums_[k * plane_];
    for (int i = 0; i < plane_; ++i) {
      sum[i] +=
          amplitude
          * lerp(near.value[i] + v * near.slope_z[i], far.value[i] + (v - 1) * far.slope_z[i], w);
    }
  });
}

void NoiseSamples::add_body(const NoiseCloud& f) {
  const auto square = [](double x) { return x * x; };
  std::vector<double> along_x(side_);
  for (int j = 0; j < side_; ++j) {
    const double height = at_[1][j] - f.center.y;
    const double s = 1 / std::max(1 + f.growth * height, double{NoiseCloud::smallest_growth});
    const double axis_x = f.center.x + f.lean_x * height, axis_z = f.center.z + f.lean_z * height;
    for (int i = 0; i < side_; ++i)
      along_x[i] = f.falloff * square((at_[0][i] - axis_x) * f.inverse_radii.x * s);
    for (int k = 0; k < side_; ++k) {
      const double along_yz = f.falloff
                              * (square(height * f.inverse_radii.y)
                                 + square((at_[2][k] - axis_z) * f.inverse_radii.z * s));
      double* sum = &sums_[k * plane_ + j * side_];
      for (int i = 0; i < side_; ++i) sum[i] -= along_x[i] + along_yz;
    }
  }
}

}  // namespace tyndall
