/// \file
/// The options of `tyndall render`.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "app/options.h"
#include "tyndall/render/part.h"

namespace tyndall::app {

struct RenderArguments : SceneArguments, session::WorkArguments {
  std::vector<std::string>
      outputs;              ///< empty: one picture named like the scene, in the current folder
  std::string report;       ///< file, empty: none
  std::string detectors;    ///< file, empty: none
  std::uint64_t batch = 0;  ///< 0: the backend's choice
  bool print_hash = false;
  std::string checkpoint;                      ///< file, empty: none
  double checkpoint_every = 60;                ///< [s]
  bool resume = false;                         ///< from the checkpoint, if it exists
  double time_limit = 0;                       ///< [s] 0: none
  double noise = 0;                            ///< see relative_noise(); 0: no limit
  std::optional<IndexRange> photons, samples;  ///< see RenderOptions
  std::string illumination;                    ///< file whose light the samples read, empty: none
  bool allow_gaps = false;                     ///< in `illumination`
  bool denoises = false;                       ///< the pictures
  std::string display;                         ///< HOST:PORT of a viewer, empty: none
  std::string preview;                         ///< file, empty: none
  double preview_every = 5;                    ///< [s]
  std::optional<FrameRange> frames;            ///< see frames.h
  double turntable = 0;                        ///< [degree] rotation of the camera over all frames
};

}  // namespace tyndall::app
