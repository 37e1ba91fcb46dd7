/// \file
/// Quotients and roots on a device.
#pragma once

#include <cstdint>

namespace tyndall::test {

/// How often a device's inverse(), divide() and root() are not what its IEEE operations give: of
/// all mantissas with several exponents, and of 2^30 pairs.
struct Differences {
  std::uint64_t inverse, divide, root;
};
Differences differences_of_ordinary();

}  // namespace tyndall::test
