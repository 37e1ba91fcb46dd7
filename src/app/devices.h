/// \file
/// What renders: the processor or a CUDA device.
#pragma once

#include <memory>
#include <string>

#include "tyndall/render/backend.h"

namespace tyndall::app {

struct DeviceName {
  enum class Kind { automatic, cpu, cuda };
  Kind kind = Kind::automatic;
  int index = 0;  ///< of a CUDA device
};

/// \param text auto, cpu, cuda or cuda:N \throws Error(usage)
DeviceName parse_device(const std::string& text);

struct Device {
  std::unique_ptr<Backend> backend;
  std::string name;  ///< "cpu", "cuda:0"
};

/// \param why_not_automatic where a CUDA device was tried, what was wrong with it: then the
/// processor it is; empty: not tried yet
/// \throws Error(device)
Device open_device(const DeviceName& name, int threads, const std::string& why_not_automatic = {});

int cuda_device_count();

/// \return a line for each device, and why there are no CUDA devices where there are none.
std::string list_devices();

}  // namespace tyndall::app
