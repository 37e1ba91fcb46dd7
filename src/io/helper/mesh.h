/// \file
/// Closed meshes on a lattice of voxels: inside tests, the fraction of each voxel that is inside,
/// and thin walls. Lengths are in voxels, with voxel centres at integers.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

namespace tyndall::io {

struct Mesh {
  std::vector<std::array<double, 3>> points;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// Moves every point to the nearest multiple of 2^-16 voxels. Up to 2^13 voxels from the origin,
/// the functions below then decide exactly on which side of an edge a voxel is.
void snap(Mesh& mesh);

/// \return whether every edge has as many faces in one direction as in the other. Vertices at the
/// same position count as one.
bool is_closed(const Mesh& mesh);

/// The crossings of the faces with the lines of voxel centres along an axis. A voxel is inside if
/// its winding number is not 0, so reversed faces bound cavities, and bodies may overlap.
class Crossings {
 public:
  struct Crossing {
    float at;         ///< coordinate along the axis
    float normal[3];  ///< of the face: along the axis, and along the two that follow it
    std::int32_t to;  ///< its contribution to the winding number of points before it
  };

  /// \pre snap(mesh) was called, and is_closed(mesh)
  Crossings(const Mesh& mesh, int axis);

  /// Calls visit(first, last) with each line's crossings, in order.
  template <class Visit>
  void for_lines(Visit&& visit) const {
    for (std::size_t line = 0; line + 1 < first_.size(); ++line)
      if (first_[line] < first_[line + 1])
        visit(all_.data() + first_[line], all_.data() + first_[line + 1]);
  }

  /// \param u, v the coordinates along the two axes that follow `axis`, cyclically
  bool is_inside(int u, int v, int along) const;

 private:
  std::array<int, 2> low_{0, 0}, size_{0, 0};
  std::vector<std::uint64_t> first_;  // index of the first crossing of each line, and the end
  std::vector<Crossing> all_;
};

/// Walls thinner than 1.5 voxels: interpolated distances lose their inside.
struct ThinWalls {
  double fraction = 0;  ///< of the area of all faces
  double width = 0;     ///< [voxel]; 5 % of the area of thin walls is thinner
};
ThinWalls thin_walls(const Crossings& x, const Crossings& y, const Crossings& z);

/// Calls set(x, y, z, fraction) for every voxel that faces intersect, with the fraction of it that
/// is inside.
void for_cut_voxels(const Mesh& mesh,
                    const std::function<void(int x, int y, int z, double fraction)>& set);

/// \return the area of all faces [voxel^2].
double area(const Mesh& mesh);

}  // namespace tyndall::io
