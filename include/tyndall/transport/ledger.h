/// \file
/// The ledger: the fate of every photon and of all its power. Each fate is counted where it
/// happens. No count is derived from another, so the balance is a check.
#pragma once

#include <cstdint>

#include "tyndall/base/deposit.h"

namespace tyndall {

inline constexpr int max_components = 16;

/// Powers are integers: 2^-24 of one photon's initial power, per RGB channel.
struct Ledger {
  using Count = std::int64_t;

  Count shot = 0;
  Count missed = 0;                     ///< never hit the box
  Count escaped[6] = {};                ///< through the faces -x +x -y +y -z +z, or absorbed there
                                        ///< by a ground
  Count absorbed[max_components] = {};  ///< by a component whose albedo is 0
  Count rouletted = 0;
  Count stalled = 0;  ///< ended in an endless flight (most_crossings, most_virtual): bias

  Count shot_power[3] = {};
  Count missed_power[3] = {};
  Count escaped_power[6][3] = {};
  Count absorbed_power[max_components][3] = {};
  Count roulette_power[3] = {};  ///< lost minus gained, 0 on average
  Count stalled_power[3] = {};
};

/// Counts of the work in walks. Unlike times, they have no noise.
struct Audit {
  using Count = std::int64_t;

  Count flights = 0;
  Count cells = 0;       ///< super-voxels entered
  Count tentative = 0;   ///< collisions, real or null
  Count real = 0;        ///< collisions with the medium
  Count lookups = 0;     ///< of densities
  Count octaves = 0;     ///< octaves of noise summed
  Count violations = 0;  ///< look-ups outside the bounds of their super-voxel: must be 0
  Count lit = 0;         ///< photons that hit medium or ground; 0 for camera paths
};

/// The account of one worker (or of a whole device).
struct Account {
  Ledger ledger;
  Audit audit;
};

/// Accounts that add up to one. Workers that share an account wait for each other. The count is a
/// power of two.
struct Accounts {
  Account* first;
  unsigned count = 1;
  TYN_HD Account& own() const { return first[worker() & (count - 1u)]; }
};

/// An account holds nothing but counts, so it is also an array of this many.
inline constexpr int account_words = sizeof(Account) / sizeof(std::int64_t);

/// Adds atomically, count by count.
inline void add(Account& sum, const Account& part) {
  std::int64_t* to = reinterpret_cast<std::int64_t*>(&sum);
  const std::int64_t* from = reinterpret_cast<const std::int64_t*>(&part);
  for (int i = 0; i < account_words; ++i) {
    if (from[i] != 0) deposit(to[i], from[i]);
  }
}

}  // namespace tyndall
