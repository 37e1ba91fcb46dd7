/// \file
/// What renders: the processor or a CUDA device.
#pragma once

#include <memory>
#include <string>

#include "tyndall/render/backend.h"
#include "tyndall/render/render.h"

namespace tyndall::session {

struct DeviceName {
  enum class Kind { automatic, cpu, cuda };
  Kind kind = Kind::automatic;
  static constexpr int all = -1;
  int index = all;  ///< of a CUDA device
};

/// \param text auto, cpu, cuda (all devices) or cuda:N \throws Error(usage)
DeviceName parse_device(const std::string& text);

struct Device {
  std::unique_ptr<Backend> backend;
  std::string name;  ///< "cpu", "cuda:0", "cuda:0+1"
};

/// \param why_not_automatic where a CUDA device was tried, what was wrong with it: then the
/// processor it is; empty: not tried yet
/// \throws Error(device)
Device open_device(const DeviceName& name, int threads, const std::string& why_not_automatic = {});

int cuda_device_count();

/// \return a line for each device, and why there are no CUDA devices where there are none.
std::string list_devices();

}  // namespace tyndall::session
