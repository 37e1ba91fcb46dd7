/// \file
/// The list of CUDA devices.
#include <string>

#include "device.h"
#include "tyndall/render/render.h"

namespace tyndall {

std::string problem(cudaError_t status) {
  int driver = 0;
  if (cudaDriverGetVersion(&driver) == cudaSuccess && driver == 0) return "no NVIDIA driver";
  return cudaGetErrorString(status);
}

CudaDevices cuda_devices() {
  CudaDevices devices;
  int count = 0;
  if (const cudaError_t status = cudaGetDeviceCount(&count); status != cudaSuccess) {
    devices.problem = problem(status);
    return devices;
  }
  for (int device = 0; device < count; ++device) {
    cudaDeviceProp p;
    require(cudaGetDeviceProperties(&p, device), "asking for the device's properties");
    devices.names.push_back(std::string(p.name) + ", " + std::to_string(p.totalGlobalMem >> 20)
                            + " MiB, sm_" + std::to_string(10 * p.major + p.minor));
  }
  if (devices.names.empty()) devices.problem = "no device";
  return devices;
}

}  // namespace tyndall
