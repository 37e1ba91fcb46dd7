/// \file
/// A NanoVDB buffer in the memory file that Tyndall receives.
#pragma once

#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <new>
#include <utility>

#include "io/helper/protocol.h"

namespace tyndall::io {

/// A buffer type as NanoVDB requires it.
class GridBuffer {
 public:
  GridBuffer(std::uint64_t size = 0) : size_(size) {
    if (size == 0) return;
    if (::ftruncate(memory_descriptor, static_cast<off_t>(size)) != 0) throw std::bad_alloc();
    void* p = ::mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_SHARED, memory_descriptor, 0);
    if (p == MAP_FAILED) throw std::bad_alloc();
    data_ = static_cast<std::uint8_t*>(p);
  }
  GridBuffer(GridBuffer&& other) noexcept { *this = std::move(other); }
  GridBuffer& operator=(GridBuffer&& other) noexcept {
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
    return *this;
  }
  ~GridBuffer() {
    if (data_) ::munmap(data_, size_);
  }

  static GridBuffer create(std::uint64_t size, const GridBuffer* = nullptr) {
    return GridBuffer(size);
  }
  std::uint8_t* data() { return data_; }
  const std::uint8_t* data() const { return data_; }
  std::uint64_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  void clear() { *this = GridBuffer(); }

 private:
  std::uint8_t* data_ = nullptr;
  std::uint64_t size_ = 0;
};

}  // namespace tyndall::io
