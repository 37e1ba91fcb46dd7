#include "render/emission.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include <glm/common.hpp>

#include "render/exponential.h"
#include "render/majorants.h"
#include "scene/values.h"
#include "tyndall/render/bounds.h"

namespace tyndall {
namespace {

/// The CIE 1931 colour matching functions [CIE1931] from 360 nm, every 10 nm. With these steps the
/// radiance of black bodies is within 1e-3 of the result with 1 nm steps.
constexpr double first_wavelength = 360e-9, wavelength_step = 10e-9;
constexpr double matching[][3] = {{0.0001299, 3.917e-06, 0.0006061},
                                  {0.0004149, 1.239e-05, 0.001946},
                                  {0.001368, 3.9e-05, 0.00645},
                                  {0.004243, 0.00012, 0.02005},
                                  {0.01431, 0.000396, 0.06785},
                                  {0.04351, 0.00121, 0.2074},
                                  {0.13438, 0.004, 0.6456},
                                  {0.2839, 0.0116, 1.3856},
                                  {0.34828, 0.023, 1.74706},
                                  {0.3362, 0.038, 1.77211},
                                  {0.2908, 0.06, 1.6692},
                                  {0.19536, 0.09098, 1.28764},
                                  {0.09564, 0.13902, 0.81295},
                                  {0.03201, 0.20802, 0.46518},
                                  {0.0049, 0.323, 0.272},
                                  {0.0093, 0.503, 0.1582},
                                  {0.06327, 0.71, 0.07825},
                                  {0.1655, 0.862, 0.04216},
                                  {0.2904, 0.954, 0.0203},
                                  {0.43345, 0.99495, 0.00875},
                                  {0.5945, 0.995, 0.0039},
                                  {0.7621, 0.952, 0.0021},
                                  {0.9163, 0.87, 0.00165},
                                  {1.0263, 0.757, 0.0011},
                                  {1.0622, 0.631, 0.0008},
                                  {1.0026, 0.503, 0.00034},
                                  {0.85445, 0.381, 0.00019},
                                  {0.6424, 0.265, 5e-05},
                                  {0.4479, 0.175, 2e-05},
                                  {0.2835, 0.107, 0},
                                  {0.1649, 0.061, 0},
                                  {0.0874, 0.032, 0},
                                  {0.04677, 0.017, 0},
                                  {0.0227, 0.00821, 0},
                                  {0.0113592, 0.004102, 0},
                                  {0.00579035, 0.002091, 0},
                                  {0.00289933, 0.001047, 0},
                                  {0.00143997, 0.00052, 0},
                                  {0.000690079, 0.0002492, 0},
                                  {0.000332301, 0.00012, 0},
                                  {0.000166151, 6e-05, 0},
                                  {8.30753e-05, 3e-05, 0},
                                  {4.15099e-05, 1.499e-05, 0},
                                  {2.06738e-05, 7.4657e-06, 0},
                                  {1.0254e-05, 3.7029e-06, 0},
                                  {5.08587e-06, 1.8366e-06, 0},
                                  {2.52253e-06, 9.1093e-07, 0},
                                  {1.25114e-06, 4.5181e-07, 0}};

/// Planck's law [W/(m^2 sr m)].
double planck(double wavelength, double temperature) {
  constexpr double h = 6.62607015e-34, c = 299792458.0, k = 1.380649e-23;
  const double squared = wavelength * wavelength;
  const double x = h * c / (wavelength * k * temperature);
  return 2 * h * c * c / (squared * squared * wavelength) / (exponential(x) - 1);
}

std::vector<float> tabulate_blackbody() {
  std::vector<float> table;
  table.reserve(BlackbodyTable::size());
  constexpr int points = BlackbodyTable::octaves * BlackbodyTable::per_octave + 1;
  float last[3] = {0, 0, 0};
  for (int i = 0; i < points; ++i) {
    const double temperature =
        double{BlackbodyTable::coldest}
        * std::ldexp(
            1.0 + static_cast<double>(i % BlackbodyTable::per_octave) / BlackbodyTable::per_octave,
            i / BlackbodyTable::per_octave);
    double x = 0, y = 0, z = 0, wavelength = first_wavelength;
    for (const auto& eye : matching) {
      const double radiance = wavelength_step * planck(wavelength, temperature);
      x += eye[0] * radiance, y += eye[1] * radiance, z += eye[2] * radiance;
      wavelength += wavelength_step;
    }
    // Rec. 709 [ITU709]. Colours outside its gamut (below 1900 K) have no blue.
    const double rgb[3] = {3.2404542 * x - 1.5371385 * y - 0.4985314 * z,
                           -0.9692660 * x + 1.8760108 * y + 0.0415560 * z,
                           0.0556434 * x - 0.2040259 * y + 1.0572252 * z};
    for (int c = 0; c < 3; ++c) {
      // Monotonic in the temperature, so that the hottest point is a bound.
      last[c] = i == 0 ? 0.0f : std::max(last[c], static_cast<float>(rgb[c]));
      table.push_back(last[c]);
    }
  }
  return table;
}

/// \return the remap of a field, or null if it has none.
const scene::Remap* remap_of(const scene::Field& field) {
  if (const auto* grid = std::get_if<scene::DenseGrid>(&field)) return &grid->remap;
  if (const auto* grid = std::get_if<scene::SparseGrid>(&field)) return &grid->remap;
  return nullptr;
}

}  // namespace

const std::vector<float>& blackbody_table() {
  static const std::vector<float> table = tabulate_blackbody();
  return table;
}

PreparedEmission prepare_emission(const std::vector<Component<AnyField>>& components, std::size_t c,
                                  const Box& box, const MajorantTables& bounds, int threads,
                                  const Stop& stop) {
  constexpr int edge = 64;
  PreparedEmission out;
  const Component<AnyField>& component = components[c];
  const Emission& emission = *component.emission;
  const glm::dvec3 extent = to_dvec3(box.extent);
  const Region matter = matter_region(bounds, c, extent);
  if (!(matter.half.x > 0)) return out;
  const Vec3f share = Vec3f{1, 1, 1} - component.albedo;
  EmissionCells cells;
  cells.nx = cells.ny = cells.nz = edge;
  cells.low = to_vec3f(matter.center - matter.half);
  cells.size = to_vec3f(2.0 * matter.half / double{edge});

  std::vector<double> most(static_cast<std::size_t>(cells.count()));  // [W/(length^3 sr)]
  std::vector<double> hottest(emission.kind == Emission::Kind::blackbody ? most.size() : 0);
  parallel_for(0, most.size(), 64, threads, [&](std::uint64_t begin, std::uint64_t end) {
    for (std::uint64_t k = begin; k < end; ++k) {
      stop_if(stop);
      const glm::dvec3 at(to_ivec3(Cells{edge, edge, edge}.place(k))), size = to_dvec3(cells.size);
      const Region region{to_dvec3(cells.low) + (at + 0.5) * size, 0.5 * size};
      const double density =
          density_bounds(component.field, in_field_space(component.to_field, region, extent)).upper;
      if (density <= 0) continue;
      if (!hottest.empty())
        hottest[k] =
            density_bounds(emission.field, in_field_space(emission.to_field, region, extent)).upper;
      most[k] =
          (1 + 4e-7) * component.extinction * density
          * emission_bound(emission, share, in_field_space(emission.to_field, region, extent));
    }
  });
  for (const double t : hottest) out.hottest = std::max(out.hottest, t);
  double sum = 0;
  for (const double m : most) sum += m;
  if (!(sum > 0)) return out;
  // Weights are rounded up, so that each is at least the cell's bound.
  const double unit = sum / 0x1p31;
  std::uint64_t total = 0;
  for (const double m : most) {
    total += static_cast<std::uint64_t>(std::ceil(m / unit));
    out.ends.push_back(static_cast<std::uint32_t>(total));
  }
  cells.unit = static_cast<float>(unit * (1 + 1e-6));
  const double volume = double{cells.size.x} * double{cells.size.y} * double{cells.size.z};
  out.power = 4 * double{pi} * double{cells.unit} * static_cast<double>(total) * volume;
  cells.ends = out.ends.data();
  out.emitter.medium = {static_cast<int>(c), cells};
  return out;
}

std::string why_dark(const Component<AnyField>& component, const scene::Component& from,
                     double power, double hottest) {
  if (component.extinction == 0) return "";  // check() reports it
  const Emission& emission = *component.emission;
  if (const auto* body = std::get_if<scene::BlackbodyEmission>(&from.emission)) {
    // Below this temperature, the visible radiance of a black body is under 1e-9 W/(m^2 sr).
    constexpr double visible = 700, fire = 2000;
    if (body->intensity == 0) return "its intensity is 0";
    const double anywhere = largest_density(emission.field);
    if (anywhere >= visible && hottest < visible && largest_density(component.field) > 0)
      return fmt::format(
          "its field is hot only where the medium is not: its largest temperature is {:.4g} K, "
          "{:.4g} K in the medium; move one of them",
          anywhere, hottest);
    if (anywhere < visible) {
      const scene::Remap* remap = remap_of(body->temperature);
      const std::string remedy = !remap || !(anywhere > 0) ? "give a hotter field"
                                 : remap->offset != 0 || !(remap->scale > 0)
                                     ? "give a remap that makes kelvins of its numbers"
                                 : anywhere <= 1.5
                                     ? fmt::format(
                                         "the convention 0 to 1 wants a remap that makes kelvins "
                                         "of it, such as \"remap\": {{\"scale\": {:.4g}}}",
                                         fire / anywhere * remap->scale)
                                     : fmt::format(
                                         "if its numbers are not kelvins, make kelvins of them, "
                                         "such as by \"remap\": {{\"scale\": {:.4g}}}",
                                         fire / anywhere * remap->scale);
      return fmt::format(
          "its largest temperature is {:.4g} K, and black bodies below {} K do not "
          "shine visibly; {}",
          anywhere, visible, remedy);
    }
  }
  if (power > 0) return "";
  if (!(largest(emission.factor) > 0)) return "";  // check() reports it
  if (!(largest_density(component.field) > 0))
    return "the component holds no matter that could shine";
  if (emission.kind != Emission::Kind::color && !(largest_density(emission.field) > 0))
    return "its field is 0 everywhere; give one that is not";
  const Vec3f share = Vec3f{1, 1, 1} - component.albedo;
  if (!(largest(share * emission.factor) > 0))
    return "matter emits as it absorbs, and it absorbs nothing in the colours of the emission; "
           "lower its albedo there";
  return "its field is 0 where the matter is; move one of them";
}

double largest_density(const AnyField& field) {
  using enum AnyField::Kind;
  if (field.kind == solid || field.kind == noise_cloud) return 1;
  return density_bounds(field, {glm::dvec3(0.0), glm::dvec3(1e30)}).upper;
}

}  // namespace tyndall
