/// \file
/// A medium is the sum of its components: independent Poisson processes, superposed.
#pragma once

#include "tyndall/medium/emission.h"
#include "tyndall/medium/fields.h"
#include "tyndall/medium/majorant_grid.h"
#include "tyndall/medium/phase.h"

namespace tyndall {

/// One field and its optical properties.
template <class Field>
struct Component {
  Field field;
  Affine to_field;        ///< local space to field space
  float extinction = 1;   ///< [1/length] at density 1
  Vec3f albedo{1, 1, 1};  ///< RGB
  Phase phase;
  const Emission* emission = nullptr;  ///< null: it emits nothing

  /// [1/length]
  TYN_HD float sigma_t(Vec3f p, TreeNodes& nodes) const {
    return extinction * density_at(field, to_field(p), nodes);
  }
  TYN_HD float sigma_t(Vec3f p) const {
    TreeNodes nodes;
    return sigma_t(p, nodes);
  }
  TYN_HD bool scatters() const { return largest(albedo) > 0.0f; }

  /// \return the radiance to add at each real collision at `p` [W/(area sr)]: emission in
  /// proportion to absorption.
  TYN_HD Vec3f emitted(Vec3f p) const {
    return Vec3f{1.0f - albedo.x, 1.0f - albedo.y, 1.0f - albedo.z} * emission->source(p);
  }

  template <class Copy>
  void relocate(Copy&& copy) {
    tyndall::relocate(field, copy);
    phase.relocate(copy);
    if (!emission) return;
    Emission moved = *emission;
    moved.relocate(copy);
    emission = copy(static_cast<const Emission*>(&moved), 1);
  }

  /// \return v < sigma_t(p), for v > 0: the same decision, bit for bit, at lower cost. Counts the
  /// cost.
  TYN_HD bool exceeds(Vec3f p, float v, Lookups& lookups) const {
    return tyndall::exceeds(field, to_field(p), extinction, v, lookups);
  }
  /// Octaves that sigma_t() sums.
  TYN_HD int octaves() const { return octave_count(field); }
};

/// How tentative collisions are decided. All ways give the same decisions.
enum class Decision {
  squeezed,  ///< evaluates only as much of the field as the decision needs
  audited,   ///< by the density, which must be within its bounds and agree with `squeezed`
  full,      ///< always by the density [SzirmayKalos2011]
};

/// Stands for no component: a null collision, with a virtual particle.
inline constexpr int virtual_particle = -1;

/// \return the decision by the density. Counts a violation if the extinction is outside its bounds
/// `at`, or if the decision differs from `squeezed`.
TYN_HD bool audit(const MajorantGrid& grid, std::size_t at, float sigma_t, float v, bool squeezed,
                  Lookups& lookups) {
  const bool real = v < sigma_t;
  const bool bounded = sigma_t >= grid.lower[at] && sigma_t <= grid.upper[at];
  if (!bounded || squeezed != real) ++lookups.violations;
  return real;
}

/// \return whether a tentative collision with `component`, 0 < v < sigma_maj in `cell`, is real.
/// Below the minorant it is real without a look-up.
template <class Component>
TYN_HD bool is_real(const MajorantGrid& grid, int index, const Component& component,
                    std::size_t cell, float v, Vec3f p, Lookups& lookups, Decision decision) {
  const std::size_t at = static_cast<std::size_t>(index) * grid.count() + cell;
  if (decision != Decision::full && v < grid.lower[at]) return true;
  ++lookups.lookups;
  if (decision == Decision::squeezed) return component.exceeds(p, v, lookups);
  const float sigma_t = component.sigma_t(p, lookups.nodes);
  lookups.octaves += component.octaves();
  if (decision == Decision::full) return v < sigma_t;
  Lookups uncounted;
  return audit(grid, at, sigma_t, v, component.exceeds(p, v, uncounted), lookups);
}

/// A medium of one component, as in most scenes. It costs no more than if there could be only one.
template <class Field>
struct SingleMedium {
  MajorantGrid super_voxels;  ///< for the super-voxel walk
  MajorantGrid whole;         ///< one cell: for Woodcock tracking
  Component<Field> single;

  TYN_HD int count() const { return 1; }
  TYN_HD const Component<Field>& component(int) const { return single; }

  /// \return the component of a tentative collision, real or null, 0 < v < total[cell], or
  /// virtual_particle. Subtracts the majorants of the components before it from v.
  TYN_HD int choose(const MajorantGrid&, std::size_t, float&) const { return 0; }

  /// \return the component of a tentative collision at `p`, 0 < v < total[cell], or
  /// virtual_particle if the collision is null.
  TYN_HD int collide(const MajorantGrid& grid, std::size_t cell, float v, Vec3f p, Lookups& lookups,
                     Decision decision = Decision::audited) const {
    return is_real(grid, 0, single, cell, v, p, lookups, decision) ? 0 : virtual_particle;
  }

  template <class Copy>
  void relocate(Copy&& copy) {
    super_voxels.relocate(copy);
    whole.relocate(copy);
    single.relocate(copy);
  }
};

/// A medium of several components, with any fields. One number v selects the component and decides
/// whether its collision is real: one look-up per tentative collision.
struct MixedMedium {
  MajorantGrid super_voxels, whole;
  const Component<AnyField>* components = nullptr;
  int component_count = 0;

  TYN_HD int count() const { return component_count; }
  TYN_HD const Component<AnyField>& component(int i) const { return components[i]; }

  TYN_HD int collide(const MajorantGrid& grid, std::size_t cell, float v, Vec3f p, Lookups& lookups,
                     Decision decision = Decision::audited) const {
    const int i = choose(grid, cell, v);
    if (i == virtual_particle) return i;
    return is_real(grid, i, components[i], cell, v, p, lookups, decision) ? i : virtual_particle;
  }

  TYN_HD int choose(const MajorantGrid& grid, std::size_t cell, float& v) const {
    for (int i = 0; i < component_count; ++i) {
      const float sigma_maj = grid.upper[static_cast<std::size_t>(i) * grid.count() + cell];
      if (v < sigma_maj) return i;
      v = v - sigma_maj;
    }
    return virtual_particle;  // v exceeds the sum by a rounding error
  }

  template <class Copy>
  void relocate(Copy&& copy);  // host only: see tyndall/render/prepare.h
};

/// Extinction of all components [1/length]. Evaluates every field: not for walks.
template <class Medium>
TYN_HD float total_sigma_t(const Medium& medium, Vec3f p, TreeNodes& nodes) {
  float sum = 0.0f;
  for (int i = 0; i < medium.count(); ++i) sum = sum + medium.component(i).sigma_t(p, nodes);
  return sum;
}
template <class Medium>
TYN_HD float total_sigma_t(const Medium& medium, Vec3f p) {
  TreeNodes nodes;
  return total_sigma_t(medium, p, nodes);
}

}  // namespace tyndall
