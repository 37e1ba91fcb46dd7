/// \file
/// Closed meshes on a lattice of voxels: what is inside, how much of each voxel, and how thin the
/// walls are. In units of voxels, whose middles are at integers.
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

/// Moves every point to the nearest multiple of 2^-16 voxels, up to 2^13 voxels from the origin:
/// there the functions below decide exactly on which side of an edge a voxel is.
void snap(Mesh& mesh);

/// \return whether every edge has as many faces on one side as on the other. Vertices in one place
/// are one.
bool is_closed(const Mesh& mesh);

/// Where the lines of voxels along an axis cross the faces. A voxel is inside where its winding
/// number is not 0: faces that are turned round make cavities, bodies may overlap.
class Crossings {
 public:
  struct Crossing {
    float at;         ///< along the axis
    float normal[3];  ///< of the face: along the axis, and along the two that follow it
    std::int32_t to;  ///< what it adds to the winding number of all that lies before it
  };

  /// \pre snapped, and closed
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
  std::vector<std::uint64_t> first_;  ///< of each line
  std::vector<Crossing> all_;
};

/// Walls of less than one and a half voxels, between which interpolated distances lose the inside.
struct ThinWalls {
  double share = 0;  ///< of the area of all faces
  double width = 0;  ///< [voxel] that a twentieth of their area is thinner than
};
ThinWalls thin_walls(const Crossings& x, const Crossings& y, const Crossings& z);

/// Calls set(x, y, z, share) for every voxel that faces pass through: the share of it that is
/// inside.
void for_cut_voxels(const Mesh& mesh,
                    const std::function<void(int x, int y, int z, double share)>& set);

/// [voxel^2] of all faces.
double area(const Mesh& mesh);

}  // namespace tyndall::io
