/// \file
/// From a scene to a picture: the two passes, their account, their hash.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "tyndall/render/backend.h"
#include "tyndall/render/parallel.h"
#include "tyndall/render/picture.h"
#include "tyndall/render/scene.h"
#include "tyndall/transport/detectors.h"
#include "tyndall/transport/ledger.h"

namespace tyndall {

struct Progress {
  const char* pass;    ///< "bounds", "photons", "matter", "pixels"
  std::uint64_t done;  ///< photons or pixel samples, of `total`
  std::uint64_t total;
};

struct RenderOptions {
  std::function<void(const Progress&)> progress;  ///< called now and then, by the calling thread
  Stop stop;                                      ///< true ends the render, which throws Stopped
  std::uint64_t batch =
      0;  ///< photons or samples per batch, 0: the backend's choice; never changes the result
};

/// The integers that identify a result: equal on every machine, thread count, batch size and
/// device.
struct Hashes {
  std::uint64_t tallies;  ///< of illumination, matter, ledger, film and detectors
  std::uint64_t pixels;   ///< of the picture's floats
};

struct PassSeconds {
  double bounds = 0, photons = 0, matter = 0, pixels = 0, depth = 0;
};

struct RenderResult {
  Picture picture;
  Ledger ledger;                ///< fate of every photon and of its power
  Audit shoot, gather;          ///< counts of the walks, majorant violations among them
  std::uint64_t clamped = 0;    ///< film samples that were cut to the film's range
  double photon_power = 0;      ///< [W] of one photon of weight 1
  int replicates = 1;           ///< that the picture is the mean of; see most_replicates
  double unshot_power[3] = {};  ///< [W] of the lights that could not meet the medium: never shot
  Detectors detectors;          ///< what there is in `detected`
  std::vector<std::int64_t> detected;  ///< see Detectors::sums; empty where nothing was asked for
  Hashes hashes{};
  PassSeconds seconds;
  std::vector<std::string> warnings;
};

/// Renders `scene` (see check()) on `backend`.
/// \throws Error (scene_invalid, out_of_memory, device; internal when the ledger does not close),
/// Stopped.
RenderResult render(const Scene& scene, Backend& backend, const RenderOptions& options = {});

/// A render is made of this many, each of its own photons, grid and samples: pixels share a grid,
/// so that only the spread between several tells the noise of a picture. Fewer where there are
/// fewer samples.
inline constexpr int most_replicates = 8;

/// \return hash of everything in `scene` that can change the picture.
std::uint64_t scene_hash(const Scene& scene);

/// Version of the arithmetic: results of different versions cannot be compared or merged bit by
/// bit.
inline constexpr int arithmetic_version = 2;

/// The CPU backend; `threads` 0: one per hardware thread. Results do not depend on
/// `instruction_set`: one of instruction_sets(), the widest if empty. Defined in src/host.
std::unique_ptr<Backend> make_cpu_backend(int threads = 0, const std::string& instruction_set = {});
/// \return those that lanes of paths are compiled for and this processor has, the widest first:
/// "v4" (AVX-512), "v3" (AVX2), "plain" (what the whole program is compiled for).
std::vector<std::string> instruction_sets();

/// One CUDA device; defined in cuda/. \throws Error(device) where there is none.
std::unique_ptr<Backend> make_cuda_backend(int device = 0);

}  // namespace tyndall
