/// \file
/// Memory of a CUDA device, and what to do where a call fails.
#pragma once

#include <cuda_runtime.h>

#include <cstddef>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "tyndall/render/error.h"
#include "tyndall/render/huge_pages.h"

namespace tyndall {

/// Why there is no device. Without any driver the runtime complains about the driver's version.
std::string problem(cudaError_t status);

/// \throws Error(device) where `status` is none of success; `what` was tried
inline void require(cudaError_t status, const std::string& what) {
  if (status == cudaSuccess) return;
  static_cast<void>(cudaGetLastError());  // which would be reported again by whoever asks next
  throw Error(ExitCode::device,
              "CUDA: " + what + " failed (" + cudaGetErrorString(status) + "); try --device cpu");
}

/// Memory of the current device that holds a number of values.
template <class T>
class Buffer {
 public:
  static_assert(std::is_trivially_copyable_v<T>);

  Buffer() = default;
  /// A copy of what the host has.
  Buffer(const T* host, std::size_t count) : count_(count) {
    allocate();
    write(host);
  }
  /// All bytes 0.
  explicit Buffer(std::size_t count) : count_(count) {
    allocate();
    clear();
  }

  T* data() const { return static_cast<T*>(data_.get()); }
  std::size_t size() const { return count_; }
  /// Of `count` values, all bytes 0. Never has the memory of both at the same time.
  void renew(std::size_t count) {
    if (data_ && count == count_) return clear();
    *this = {};
    *this = Buffer(count);
  }
  void clear() {
    if (count_ == 0) return;
    require(cudaMemset(data_.get(), 0, bytes()), "clearing device memory");
  }

  /// \param host [size()]
  void write(const T* host) {
    if (count_ == 0) return;
    require(cudaMemcpy(data_.get(), host, bytes(), cudaMemcpyHostToDevice),
            "copying to the device");
  }
  /// Waits for the kernels before it.
  std::vector<T> read() const {
    std::vector<T> host;
    if (count_ == 0) return host;
    resize_in_huge_pages(host, count_);
    require(cudaMemcpy(host.data(), data_.get(), bytes(), cudaMemcpyDeviceToHost),
            "copying from the device");
    return host;
  }

 private:
  struct Free {
    void operator()(void* p) const { cudaFree(p); }
  };
  std::size_t bytes() const { return count_ * sizeof(T); }
  void allocate() {
    void* p = nullptr;
    require(cudaMalloc(&p, bytes() > 0 ? bytes() : 1),
            "allocating " + std::to_string(bytes()) + " bytes");
    data_.reset(p);
  }

  std::size_t count_ = 0;
  std::unique_ptr<void, Free> data_;
};

/// Device memory for values of any kind, which grows where it must.
class Room {
 public:
  /// \return for `count` values, until the next call; of any content.
  template <class T>
  T* room(std::size_t count) {
    static_assert(std::is_trivially_copyable_v<T>);
    if (bytes_.size() < count * sizeof(T)) {
      bytes_ = {};
      bytes_ = Buffer<std::byte>(count * sizeof(T));
    }
    return reinterpret_cast<T*>(bytes_.data());
  }
  void clear() { bytes_.clear(); }

 private:
  Buffer<std::byte> bytes_;
};

/// Copies of the host's arrays on the current device, which live as long as this.
class DeviceArrays {
 public:
  template <class T>
  const T* keep(const T* host, std::size_t count) {
    auto buffer = std::make_shared<Buffer<T>>(host, count);
    arrays_.push_back(buffer);
    return buffer->data();
  }
  void clear() { arrays_.clear(); }

 private:
  std::vector<std::shared_ptr<void>> arrays_;
};

}  // namespace tyndall
