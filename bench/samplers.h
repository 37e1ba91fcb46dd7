/// \file
/// The samplers as published [SzirmayKalos2011]: every tentative collision evaluates the density.
#pragma once

#include "tyndall/transport/walk.h"

namespace tyndall::bench {

struct SuperVoxel2011 {
  template <class Medium>
  TYN_HD Flight fly(const Medium& medium, Path& path, const RandomStream& random,
                    Audit& audit) const {
    return track<Decision::full>(medium, medium.super_voxels, path, random, audit);
  }
};

struct Woodcock2011 {
  template <class Medium>
  TYN_HD Flight fly(const Medium& medium, Path& path, const RandomStream& random,
                    Audit& audit) const {
    return track<Decision::full>(medium, medium.whole, path, random, audit);
  }
};

}  // namespace tyndall::bench
