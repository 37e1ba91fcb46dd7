/// \file
/// Selects the device that renders: the processor or CUDA devices.
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

/// \param why_not_automatic the error of a CUDA device that was tried: `automatic` then opens the
/// processor; empty: none was tried
/// \throws Error(device)
Device open_device(const DeviceName& name, int threads, const std::string& why_not_automatic = {});

int cuda_device_count();

/// \return a line for each device, and the reason if there are no CUDA devices.
std::string list_devices();

}  // namespace tyndall::session
