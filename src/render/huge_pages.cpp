#include "tyndall/render/huge_pages.h"

#if defined(__linux__)
#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#endif

namespace tyndall {

void advise_huge_pages(void* bytes, std::size_t size) {
#if defined(__linux__)
  const auto page = static_cast<std::uintptr_t>(::sysconf(_SC_PAGESIZE));
  const auto begin = (reinterpret_cast<std::uintptr_t>(bytes) + page - 1) / page * page;
  const auto end = (reinterpret_cast<std::uintptr_t>(bytes) + size) / page * page;
  constexpr std::size_t worth_it = std::size_t{4} << 20;
  if (begin + worth_it > end) return;
  ::madvise(reinterpret_cast<void*>(begin), end - begin, MADV_HUGEPAGE);  // only advice
#else
  static_cast<void>(bytes);
  static_cast<void>(size);
#endif
}

}  // namespace tyndall
