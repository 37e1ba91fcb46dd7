#include <cstdio>
#include <vector>

#include "free_paths.h"

__global__ void fly_all(const __grid_constant__ Cloud cloud, unsigned photons, float* lengths) {
  const unsigned i = blockIdx.x * blockDim.x + threadIdx.x;
  if (i < photons) lengths[i] = fly(cloud, i);
}

int main() {
  const tyndall::Scene scene = cloud_scene();
  const tyndall::PreparedScene prepared = tyndall::prepare(scene, 0);
  Cloud cloud = std::get<Cloud>(prepared.medium);
  // Its tables go to the device.
  cloud.relocate([](const auto* host, std::size_t count) {
    void* device = nullptr;
    cudaMalloc(&device, count * sizeof *host);
    cudaMemcpy(device, host, count * sizeof *host, cudaMemcpyHostToDevice);
    return static_cast<decltype(host)>(device);
  });
  constexpr unsigned photons = 100000;
  float* lengths = nullptr;
  cudaMalloc(&lengths, photons * sizeof(float));
  fly_all<<<(photons + 127) / 128, 128>>>(cloud, photons, lengths);
  std::vector<float> host(photons);
  if (cudaMemcpy(host.data(), lengths, photons * sizeof(float), cudaMemcpyDeviceToHost)
      != cudaSuccess) {
    std::fprintf(stderr, "%s\n", cudaGetErrorString(cudaGetLastError()));
    return 1;
  }
  double sum = 0;
  unsigned through = 0;
  for (const float length : host) length > 1 ? void(++through) : void(sum += length);
  std::printf("%u photons: %u through, the others fly %.6f on average\n", photons, through,
              sum / (photons - through));
}
