/// \file
/// Large arrays that are read at random want large pages: with small ones each look-up also misses
/// the table of pages.
#pragma once

#include <cstddef>
#include <vector>

namespace tyndall {

/// Asks the system for large pages, where it knows any. Of memory that was not written to yet.
void advise_huge_pages(void* bytes, std::size_t size);

/// An empty vector becomes one of `count` zeros.
template <class T>
void resize_in_huge_pages(std::vector<T>& values, std::size_t count) {
  values.reserve(count);
  advise_huge_pages(values.data(), count * sizeof(T));
  values.resize(count);
}

}  // namespace tyndall
