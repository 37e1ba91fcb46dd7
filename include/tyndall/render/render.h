/// \file
/// From a scene to a picture: the two passes, their account, their hash.
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

/// When a render may be looked at, or left: its integers are whole then.
enum class Moment {
  batch,  ///< some cells, photons or samples more, often
  slice,  ///< all pixels have some samples more
  round,  ///< the replicates begun have about as many each: their spread tells the noise
};

struct RenderOptions {
  std::function<void(const Progress&)> progress;  ///< called now and then, by the calling thread
  /// True interrupts the render: the batch under way ends early, and go_on is asked. Where there is
  /// no go_on, or nothing to keep yet, the render throws Stopped.
  Stop stop;
  /// False ends the render in order.
  std::function<bool(Renderer&, Moment)> go_on;
  std::uint64_t batch =
      0;  ///< photons or samples per batch, 0: the backend's choice; never changes the result
  /// Those alone. Photons without samples are only shot; samples without photons have those of
  /// their replicates shot.
  std::optional<IndexRange> photons, samples;
  /// Samples whose replicate has no photons, where it should, are left out: else they are refused.
  bool allow_gaps = false;
  /// Also where photons are only shot: see bake.h.
  bool measures_matter = false;
  /// The light of what is gathered stays, for look().
  bool keeps_light = false;
  /// Of so many replicates the light is held at once, and they are gathered by turns: what has a
  /// limit ends soon after it. 1: one after the other.
  int most_lights = 1;
  /// [s] from the start of the render; photons and samples that do not fit are left out. Half of it
  /// is for the photons of the first replicates, two at least where most_lights is.
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
  std::uint64_t clamped = 0;    ///< film samples that were cut to the film's range
  double noise = 0;             ///< see relative_noise()
  int unlit_replicates = 0;     ///< see unlit_replicates()
  double photon_power = 0;      ///< [W] of one photon of weight 1
  Ranges photons, samples;      ///< that are done
  bool is_complete = true;      ///< whether these are all
  bool is_preview = false;      ///< a glance at unfinished light, never merged
  std::string limit;            ///< that was asked for and ended the render; empty: none
  int replicates = 1;           ///< that the picture is the mean of; see most_replicates
  double unshot_power[3] = {};  ///< [W] of the lights that could not meet the medium: never shot
  std::vector<std::int64_t> detected;  ///< see Detectors::sums; empty where nothing was asked for
  Hashes hashes{};
  PassSeconds seconds;
  std::vector<std::string> warnings;  ///< those of ResolvedScene first
};

/// One render, from a scene to its result, that can be left between two batches, looked at, and
/// taken up again elsewhere.
class Renderer {
 public:
  /// Prepares the scene. \throws as render()
  Renderer(const ResolvedScene& scene, Backend& backend, RenderOptions options = {});
  ~Renderer();

  /// Takes up what was done before: photons whose light it keeps, samples, a slice under way.
  /// \pre nothing has been run \throws Error(input_missing) where it is of another scene; `name` is
  /// its file's
  void resume(Partial part, const std::string& name);
  /// \return whether all that was asked for is done; false: go_on ended it, or the time.
  bool run();

  /// Another camera, or another seed of its paths: no sample is done then, but bounds, light and
  /// matter stay.
  /// \param scene differs in these alone \pre run() was true, with RenderOptions::keeps_light
  void look(const ResolvedScene& scene);

  /// \return all that is done. Where run() threw Stopped: what it had last written down.
  const Partial& part();
  /// \return the scene as it is rendered.
  const PreparedScene& scene() const;
  /// \return whether there are samples of all pixels.
  bool has_picture() const;
  /// \return whether photons alone were asked for.
  bool shoots_only() const;
  /// \return part() as a picture.
  RenderResult result();
  /// \return whether there is light to look at, and matter to divide it by.
  bool has_preview() const;
  /// \return a sample or a few of every pixel that `seconds` are enough for, of the light so far;
  /// where they are not enough for one, those that have none are black, and it has no samples.
  /// \pre has_preview()
  RenderResult preview(double seconds);

 private:
  class Work;
  std::unique_ptr<Work> work_;
};

/// \return the picture, the hashes and the account of a part.
RenderResult develop(const Partial& part);

/// Renders `scene` on `backend`. A Scene is checked first.
/// \throws Error (scene_invalid, out_of_memory, device; internal when the ledger does not close),
/// Stopped.
RenderResult render(const ResolvedScene& scene, Backend& backend,
                    const RenderOptions& options = {});

/// A render is made of this many, each of its own photons, grid and samples: pixels share a grid,
/// so that only the spread between several tells the noise of a picture. Fewer where there are
/// fewer samples.
inline constexpr int most_replicates = 8;

/// \return hash of everything in `scene` that can change the picture.
std::uint64_t scene_hash(const ResolvedScene& scene);
/// \return hash of everything that can change the light: all but the camera and its paths.
std::uint64_t light_hash(const ResolvedScene& scene);

/// Version of the arithmetic: results of different versions cannot be compared or merged bit by
/// bit.
inline constexpr int arithmetic_version = 3;

/// The CPU backend; `threads` 0: one per hardware thread. Results do not depend on
/// `instruction_set`: one of instruction_sets(), the widest if empty. Defined in src/host.
std::unique_ptr<Backend> make_cpu_backend(int threads = 0, const std::string& instruction_set = {});
/// \return those that lanes of paths are compiled for and this processor has, the widest first:
/// "v4" (AVX-512), "v3" (AVX2), "plain" (what the whole program is compiled for).
std::vector<std::string> instruction_sets();

/// Several backends as one: each works on a thread of the host, which draws chunks of every range,
/// and their tallies are added up. \pre one at least
std::unique_ptr<Backend> make_combined_backend(std::vector<std::unique_ptr<Backend>> backends);

struct CudaDevices {
  std::vector<std::string> names;
  std::string problem;  ///< why there are none
};
/// Those of this machine; defined in cuda/.
CudaDevices cuda_devices();
/// One CUDA device; defined in cuda/. \throws Error(device) where there is none.
std::unique_ptr<Backend> make_cuda_backend(int device = 0);

}  // namespace tyndall
