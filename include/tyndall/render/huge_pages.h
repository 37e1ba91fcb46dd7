/// \file
/// Huge pages for large arrays that are read at random. With small pages each look-up also misses
/// the TLB.
#pragma once

#include <cstddef>
#include <vector>

namespace tyndall {

/// Requests huge pages if the system supports them. \pre the memory has not been written yet
void advise_huge_pages(void* bytes, std::size_t size);

/// Resizes an empty vector to `count` zeros.
template <class T>
void resize_in_huge_pages(std::vector<T>& values, std::size_t count) {
  values.reserve(count);
  advise_huge_pages(values.data(), count * sizeof(T));
  values.resize(count);
}

}  // namespace tyndall
