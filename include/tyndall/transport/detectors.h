/// \file
/// Detectors: histograms of the photons, beside the ledger. They record where light leaves and is
/// absorbed, its path length, its number of scatterings, and its exit angle. Each detector sorts
/// the integers that the ledger counts, so that its bins add up to the ledger, bit for bit.
#pragma once

#include <cstddef>
#include <cstdint>

#include "tyndall/base/deposit.h"
#include "tyndall/medium/majorant_grid.h"

namespace tyndall {

/// The history of a photon.
struct Track {
  float length = 0;  ///< [length] since it entered the medium
  std::int32_t scatterings = 0;
};

/// RGB sums in units of 2^-24 of a photon, one detector after the other: flux, path length,
/// scatterings, exit angle, absorbed. The last bins include all larger values. A size of 0 means
/// that the detector is off.
struct Detectors {
  int flux_u = 0, flux_v = 0;  ///< [faces][v][u] through a face, axes as in point_on_face()
  int lengths = 0;             ///< by path length
  int scatterings = 0;         ///< by scatterings, from 0
  int angles = 0;              ///< by the cosine to the outward normal of the face
  int nx = 0, ny = 0, nz = 0;  ///< [z][y][x] absorbed in a voxel
  float inverse_length = 0;    ///< [1/length] 1 over the width of a bin of path lengths
  Vec3f inverse_extent{1, 1, 1};
  Vec3f inverse_voxel_size{1, 1, 1};  ///< [1/length]
  std::int64_t* sums = nullptr;       ///< [count()][3], or null: all detectors are off

  // The first bin of each detector.
  TYN_HD std::size_t length_begin() const { return 6 * product(flux_u, flux_v, 1); }
  TYN_HD std::size_t scattering_begin() const {
    return length_begin() + static_cast<std::size_t>(lengths);
  }
  TYN_HD std::size_t angle_begin() const {
    return scattering_begin() + static_cast<std::size_t>(scatterings);
  }
  TYN_HD std::size_t absorbed_begin() const {
    return angle_begin() + static_cast<std::size_t>(angles);
  }
  TYN_HD std::size_t count() const { return absorbed_begin() + product(nx, ny, nz); }

  // Events to record. They expect sums.

  /// Light that leaves at `p` through `face`, or that the ground there absorbs.
  TYN_HD void escape(int face, Vec3f p, Vec3f direction, Track track,
                     const std::int64_t (&units)[3]) const {
    const int axis = face / 2;
    if (flux_u > 0) {
      const float u = axis == 0 ? p.y * inverse_extent.y : p.x * inverse_extent.x;
      const float v = axis == 2 ? p.y * inverse_extent.y : p.z * inverse_extent.z;
      add(product(face * flux_v + bin(v, flux_v), flux_u, 1)
              + static_cast<std::size_t>(bin(u, flux_u)),
          units);
    }
    if (lengths > 0) {
      const int i = Cells::coordinate(track.length, inverse_length, lengths);
      add(length_begin() + static_cast<std::size_t>(i), units);
    }
    if (scatterings > 0) {
      const int i = track.scatterings < scatterings ? track.scatterings : scatterings - 1;
      add(scattering_begin() + static_cast<std::size_t>(i), units);
    }
    if (angles > 0) {
      const float cosine = abs(axis == 0 ? direction.x : axis == 1 ? direction.y : direction.z);
      add(angle_begin() + static_cast<std::size_t>(bin(cosine, angles)), units);
    }
  }

  /// Light that the medium absorbs at `p`.
  TYN_HD void absorb(Vec3f p, const std::int64_t (&units)[3]) const {
    if (nx == 0) return;
    const Cells voxels{nx, ny, nz};
    const Cells::Place at = voxels.place_of(p, inverse_voxel_size);
    add(absorbed_begin() + voxels.index(at.i, at.j, at.k), units);
  }

 private:
  TYN_HD static std::size_t product(int a, int b, int c) {
    return static_cast<std::size_t>(a) * static_cast<std::size_t>(b) * static_cast<std::size_t>(c);
  }
  TYN_HD static int bin(float share, int n) {
    return Cells::coordinate(share, static_cast<float>(n), n);
  }
  TYN_HD void add(std::size_t at, const std::int64_t (&units)[3]) const {
    std::int64_t* sum = sums + 3 * at;
    for (int c = 0; c < 3; ++c)
      if (units[c] != 0) deposit(sum[c], units[c]);
  }
};

}  // namespace tyndall
