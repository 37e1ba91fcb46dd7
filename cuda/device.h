/// \file
/// Memory of a CUDA device, and the handling of failed calls.
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

/// The reason for a missing device. Without a driver the runtime would report a wrong version.
std::string problem(cudaError_t status);

/// \param what the attempted action \throws Error(device) if `status` is an error
inline void require(cudaError_t status, const std::string& what) {
  if (status == cudaSuccess) return;
  static_cast<void>(cudaGetLastError());  // the next check would report it again
  throw Error(ExitCode::device,
              "CUDA: " + what + " failed (" + cudaGetErrorString(status) + "); try --device cpu");
}

/// An array of values in the memory of the current device.
template <class T>
class Buffer {
 public:
  static_assert(std::is_trivially_copyable_v<T>);

  Buffer() = default;
  /// Copies values from the host.
  Buffer(const T* host, std::size_t count) : count_(count) {
    allocate();
    write(host);
  }
  /// Sets all bytes to 0.
  explicit Buffer(std::size_t count) : count_(count) {
    allocate();
    clear();
  }

  T* data() const { return static_cast<T*>(data_.get()); }
  std::size_t size() const { return count_; }
  /// Resizes to `count` values and sets all bytes to 0. The old memory is freed first.
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
  /// Copies to the host. Waits for earlier kernels.
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

/// Device memory for values of any type. It grows on demand.
class Room {
 public:
  /// \return memory for `count` values, valid until the next call; the content is undefined.
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

/// Copies of the host's arrays on the current device. They live as long as this object.
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
