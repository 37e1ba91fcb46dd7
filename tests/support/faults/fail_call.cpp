// A library for LD_PRELOAD that makes one call of the program fail, counted from the start of main:
//   FAIL_CALL=write FAIL_AT=7 FAIL_FROM=own|libraries|all program ...
// With FAIL_AT=0 no call fails. Writes the number of calls to the file FAIL_COUNT if that is set.
// Own calls are those from the program's code; for memory, operator new as well as malloc.
#include <dlfcn.h>
#include <elf.h>
#include <fcntl.h>
#include <link.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdarg>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <new>

extern "C" void* __libc_malloc(std::size_t);

namespace {

std::atomic<bool> active = false;
std::atomic<long> calls = 0;
long fail_at = 0;
char failing_call[16] = "", from[16] = "all";
std::uintptr_t text_begin = 0, text_end = 0;  // of the program

template <class Function>
Function next(const char* name) {
  return reinterpret_cast<Function>(::dlsym(RTLD_NEXT, name));
}

/// \return whether this call must fail.
bool fails(const char* call, const void* caller) {
  if (!active || std::strcmp(call, failing_call) != 0) return false;
  const auto at = reinterpret_cast<std::uintptr_t>(caller);
  const bool is_own = at >= text_begin && at < text_end;
  if (from[0] == 'o' && !is_own) return false;
  if (from[0] == 'l' && is_own) return false;
  return ++calls == fail_at;
}

int find_text(dl_phdr_info* info, std::size_t, void*) {
  for (int i = 0; i < info->dlpi_phnum; ++i) {
    const auto& segment = info->dlpi_phdr[i];
    if (segment.p_type != PT_LOAD || (segment.p_flags & PF_X) == 0) continue;
    text_begin = info->dlpi_addr + segment.p_vaddr;
    text_end = text_begin + segment.p_memsz;
  }
  return 1;  // stops: the first object is the program
}

using Main = int(int, char**, char**);
Main* real_main = nullptr;

int counted_main(int argc, char** argv, char** environment) {
  ::dl_iterate_phdr(find_text, nullptr);
  const auto copy = [](char(&to)[16], const char* name) {
    if (const char* value = std::getenv(name)) std::strncpy(to, value, sizeof to - 1);
  };
  copy(failing_call, "FAIL_CALL");
  copy(from, "FAIL_FROM");
  if (const char* at = std::getenv("FAIL_AT")) fail_at = std::atol(at);
  ::unsetenv("LD_PRELOAD");  // not for the process that reads volumes
  active = true;
  return real_main(argc, argv, environment);
}

struct Count {
  ~Count() {
    active = false;
    const char* path = std::getenv("FAIL_COUNT");
    if (path == nullptr) return;
    if (std::FILE* file = std::fopen(path, "w")) {
      std::fprintf(file, "%ld\n", calls.load());
      std::fclose(file);
    }
  }
} count;

void* allocate(std::size_t size, const void* caller) {
  if (fails("malloc", caller)) throw std::bad_alloc();
  void* const p = __libc_malloc(size > 0 ? size : 1);
  if (p == nullptr) throw std::bad_alloc();
  return p;
}

}  // namespace

#define CALLER __builtin_return_address(0)
#define EXPORT __attribute__((visibility("default")))

EXPORT void* operator new(std::size_t size) { return allocate(size, CALLER); }
EXPORT void* operator new[](std::size_t size) { return allocate(size, CALLER); }

extern "C" {

EXPORT int __libc_start_main(Main* main, int argc, char** argv, void (*init)(), void (*fini)(),
                             void (*rtld_fini)(), void* stack_end) {
  real_main = main;
  return next<int (*)(Main*, int, char**, void (*)(), void (*)(), void (*)(), void*)>(
      "__libc_start_main")(counted_main, argc, argv, init, fini, rtld_fini, stack_end);
}

EXPORT void* malloc(std::size_t size) {
  if (active && fails("malloc", CALLER)) {
    errno = ENOMEM;
    return nullptr;
  }
  return __libc_malloc(size);
}

EXPORT int open(const char* path, int flags, ...) {
  va_list rest;
  va_start(rest, flags);
  const mode_t mode = va_arg(rest, mode_t);
  va_end(rest);
  if (fails("open", CALLER)) {
    errno = EMFILE;
    return -1;
  }
  return next<int (*)(const char*, int, ...)>("open")(path, flags, mode);
}

EXPORT int open64(const char* path, int flags, ...) {
  va_list rest;
  va_start(rest, flags);
  const mode_t mode = va_arg(rest, mode_t);
  va_end(rest);
  if (fails("open", CALLER)) {
    errno = EMFILE;
    return -1;
  }
  return next<int (*)(const char*, int, ...)>("open64")(path, flags, mode);
}

EXPORT ssize_t write(int file, const void* bytes, std::size_t size) {
  if (fails("write", CALLER)) {
    errno = ENOSPC;
    return -1;
  }
  return next<ssize_t (*)(int, const void*, std::size_t)>("write")(file, bytes, size);
}

EXPORT ssize_t read(int file, void* bytes, std::size_t size) {
  if (fails("read", CALLER)) {
    errno = EIO;
    return -1;
  }
  return next<ssize_t (*)(int, void*, std::size_t)>("read")(file, bytes, size);
}

EXPORT int fsync(int file) {
  if (fails("fsync", CALLER)) {
    errno = EIO;
    return -1;
  }
  return next<int (*)(int)>("fsync")(file);
}

EXPORT int rename(const char* a, const char* b) noexcept {
  if (fails("rename", CALLER)) {
    errno = EACCES;
    return -1;
  }
  return next<int (*)(const char*, const char*)>("rename")(a, b);
}

EXPORT void* mmap(void* at, std::size_t size, int protection, int flags, int file,
                  off_t offset) noexcept {
  if (fails("mmap", CALLER)) {
    errno = ENOMEM;
    return MAP_FAILED;
  }
  return next<void* (*)(void*, std::size_t, int, int, int, off_t)>("mmap")(at, size, protection,
                                                                           flags, file, offset);
}

}  // extern "C"
