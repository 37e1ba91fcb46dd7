/// \file
/// Rendering, from a scene to a picture: the two passes, their account, their hash.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tyndall/render/backend.h"
#include "tyndall/render/parallel.h"
#include "tyndall/render/part.h"
#include "tyndall/render/picture.h"
#include "tyndall/render/resolved_scene.h"
#include "tyndall/transport/ledger.h"

namespace tyndall {

struct Progress {
  const char* pass;    ///< "bounds", "photons", "matter", "pixels"
  std::uint64_t done;  ///< photons or pixel samples, of `total`
  std::uint64_t total;
};

struct PreparedScene;
class Renderer;

/// The moments when a render may be previewed or ended: its integers are complete then.
enum class Moment {
  batch,  ///< some more cells, photons or samples are done; often
  slice,  ///< all pixels have some more samples
  round,  ///< replicates in progress have about equal counts: their spread measures the noise
};

struct RenderOptions {
  std::function<void(const Progress&)> progress;  ///< called now and then, by the calling thread
  /// True interrupts the render: the current batch ends early, and go_on is called. Without go_on,
  /// or with nothing to keep yet, the render throws Stopped.
  Stop stop;
  /// Called at each Moment. False ends the render in order.
  std::function<bool(Renderer&, Moment)> go_on;
  std::uint64_t batch =
      0;  ///< photons or samples per batch, 0: the backend's choice; never changes the result
  /// Restricts the render to these. Photons without samples are only traced. For samples without
  /// photons, the photons of their replicates are traced.
  std::optional<IndexRange> photons, samples;
  /// Leaves out samples of a replicate that lacks its photons; otherwise they are refused.
  bool allow_gaps = false;
  /// Measures the medium even if photons are only traced: see bake.h.
  bool measures_matter = false;
  /// Keeps the light of gathered replicates, for look().
  bool keeps_light = false;
  /// Number of replicates whose light is in memory at once. They are gathered by turns, so that a
  /// render with a limit ends soon after it. 1: one after the other.
  int most_lights = 1;
  /// [s] from the start of the render; photons and samples that do not fit are left out. Half of it
  /// is for the photons of the first replicates, at least two of them if most_lights is.
  double time_limit = 0;  ///< 0: none
};

/// The integers that identify a result: equal on every machine, thread count, batch size and
/// device.
struct Hashes {
  std::uint64_t tallies;  ///< of illumination, matter, ledger, film and detectors
  std::uint64_t pixels;   ///< of the picture's floats
};

struct PassSeconds {
  double bounds = 0, photons = 0, pixels = 0;
  measurement::Each<double> measured{};
};

struct RenderResult {
  Frame frame;
  Picture picture;
  Ledger ledger;                ///< fate of every photon and of its power
  Audit shoot, gather;          ///< counts of the walks, majorant violations among them
  std::uint64_t clamped = 0;    ///< film samples that were clamped to the film's range
  double noise = 0;             ///< see relative_noise()
  int unlit_replicates = 0;     ///< see unlit_replicates()
  double photon_power = 0;      ///< [W] of one photon of weight 1
  Ranges photons, samples;      ///< completed
  bool is_complete = true;      ///< whether these are all
  bool is_preview = false;      ///< made from unfinished light, never merged
  std::string limit;            ///< requested limit that ended the render; empty: none
  int replicates = 1;           ///< number whose mean is the picture; see most_replicates
  double unshot_power[3] = {};  ///< [W] of the lights that could not hit the medium: never traced
  std::vector<std::int64_t> detected;  ///< see Detectors::sums; empty: the detectors are off
  Hashes hashes{};
  PassSeconds seconds;
  std::vector<std::string> warnings;  ///< begins with those of ResolvedScene
};

/// One render, from a scene to its result. It can be ended between two batches, previewed, and
/// resumed elsewhere.
class Renderer {
 public:
  /// Prepares the scene. \throws as render()
  Renderer(const ResolvedScene& scene, Backend& backend, RenderOptions options = {});
  ~Renderer();

  /// Resumes earlier work: photons with their light, samples, a slice in progress. \param name of
  /// the part's file \pre nothing has been run \throws Error(input_missing) if `part` is of another
  /// scene
  void resume(Partial part, const std::string& name);
  /// \return whether all requested work is done; false: go_on or the time limit ended it.
  bool run();

  /// Changes the camera, or the seed of its paths. This discards the samples, but keeps bounds,
  /// light and measurement of the medium.
  /// \param scene differs in these alone \pre run() was true, with RenderOptions::keeps_light
  void look(const ResolvedScene& scene);

  /// \return all completed work. After run() threw Stopped: its last complete state.
  const Partial& part();
  /// \return the scene, prepared.
  const PreparedScene& scene() const;
  /// \return whether there are samples of all pixels.
  bool has_picture() const;
  /// \return whether only photons were requested.
  bool shoots_only() const;
  /// \return part() as a picture.
  RenderResult result();
  /// \return whether there are light (N) and a measured medium (D) for a preview.
  bool has_preview() const;
  /// \return a picture from the light so far, with one or a few samples per pixel in `seconds`. If
  /// there is no time for one, pixels without it are black, and the result has no samples.
  /// \pre has_preview()
  RenderResult preview(double seconds);

 private:
  class Work;
  std::unique_ptr<Work> work_;
};

/// \return the picture, the hashes and the account of a part.
RenderResult develop(const Partial& part);

/// Renders `scene` on `backend`. A Scene is checked first.
/// \throws Error (scene_invalid, out_of_memory, device; internal if the ledger does not close),
/// Stopped.
RenderResult render(const ResolvedScene& scene, Backend& backend,
                    const RenderOptions& options = {});

/// The number of replicates of a render. Each has its own photons, grid and samples: pixels share a
/// grid, so that only the spread between several grids shows the noise of a picture. There are
/// fewer if there are fewer samples.
inline constexpr int most_replicates = 8;

/// \return a hash of everything in `scene` that can change the picture.
std::uint64_t scene_hash(const ResolvedScene& scene);
/// \return a hash of everything that can change the light: all but the camera and its paths.
std::uint64_t light_hash(const ResolvedScene& scene);

/// Version of the arithmetic: results of different versions cannot be compared or merged bit by
/// bit.
inline constexpr int arithmetic_version = 3;

/// Makes the CPU backend; `threads` 0: one per hardware thread. `instruction_set` is one of
/// instruction_sets(), the widest if empty; results do not depend on it. Defined in src/host.
std::unique_ptr<Backend> make_cpu_backend(int threads = 0, const std::string& instruction_set = {});
/// \return the instruction sets that lanes of paths are compiled for and this processor supports,
/// the widest first: "v4" (AVX-512), "v3" (AVX2), "plain" (the target of the whole program).
std::vector<std::string> instruction_sets();

/// Combines several backends into one. Each works on a thread of the host, which takes chunks of
/// every range; their tallies are added up. \pre at least one
std::unique_ptr<Backend> make_combined_backend(std::vector<std::unique_ptr<Backend>> backends);

struct CudaDevices {
  std::vector<std::string> names;
  std::string problem;  ///< the reason if there are none
};
/// \return the CUDA devices of this machine. Defined in cuda/.
CudaDevices cuda_devices();
/// Makes the backend of one CUDA device. Defined in cuda/. \throws Error(device) if there is none
std::unique_ptr<Backend> make_cuda_backend(int device = 0);

}  // namespace tyndall
