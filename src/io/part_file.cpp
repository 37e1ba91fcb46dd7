#include "io/part_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstring>
#include <string_view>
#include <system_error>
#include <type_traits>
#include <vector>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <fmt/format.h>
#include <zstd.h>

#include "tyndall/render/error.h"
#include "tyndall/render/render.h"

namespace tyndall::io {
namespace {

static_assert(std::endian::native == std::endian::little, "the format is little-endian");

constexpr std::string_view magic = "TYNPART\n";
constexpr std::size_t name_size = 16, most_in_chunk = std::size_t{16} << 20;
constexpr int compression = 1;  // fast: the render waits for its checkpoints

struct ChunkHeader {
  char name[name_size];
  std::uint64_t raw, stored, checksum;  // sizes [byte] before and after compression; XXH3
};
static_assert(sizeof(ChunkHeader) == 40);

/// \return XXH3 of the chunk without its checksum.
std::uint64_t checksum(const ChunkHeader& header, std::string_view stored) {
  XXH3_state_t state;
  XXH3_64bits_reset(&state);
  XXH3_64bits_update(&state, &header, offsetof(ChunkHeader, checksum));
  XXH3_64bits_update(&state, stored.data(), stored.size());
  return XXH3_64bits_digest(&state);
}

// ---- Values, in one order for writing and reading.

/// Appends values.
class Packer {
 public:
  template <class T>
  void operator()(const T& value) {
    static_assert(std::is_arithmetic_v<T>);
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  void operator()(const std::string& text) {
    (*this)(std::uint64_t{text.size()});
    bytes_ += text;
  }
  template <class T>
  void operator()(const std::vector<T>& list) {
    (*this)(std::uint64_t{list.size()});
    for (const T& element : list) (*this)(element);
  }
  void operator()(const IndexRange& range) {
    (*this)(range.begin);
    (*this)(range.end);
  }
  void operator()(const Ranges& ranges) { (*this)(ranges.list()); }
  void operator()(const Account& account) {
    bytes_.append(reinterpret_cast<const char*>(&account), sizeof account);
  }

  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

struct Malformed {};

/// Reads values in the order of Packer. \throws Malformed
class Unpacker {
 public:
  explicit Unpacker(std::string_view bytes) : bytes_(bytes) {}

  template <class T>
  void operator()(T& value) {
    static_assert(std::is_arithmetic_v<T>);
    take(&value, sizeof value);
  }
  void operator()(bool& value) {
    unsigned char byte = 0;
    take(&byte, 1);
    value = byte != 0;
  }
  void operator()(std::string& text) {
    text.resize(size(1));
    take(text.data(), text.size());
  }
  template <class T>
  void operator()(std::vector<T>& list) {
    list.resize(size(sizeof(std::uint64_t)));
    for (T& element : list) (*this)(element);
  }
  void operator()(IndexRange& range) {
    (*this)(range.begin);
    (*this)(range.end);
    if (range.begin > range.end) throw Malformed{};
  }
  void operator()(Ranges& ranges) {
    std::vector<IndexRange> list;
    (*this)(list);
    if (list.size() > 4096) throw Malformed{};  // never written, and slow to read
    for (std::size_t i = 1; i < list.size(); ++i)
      if (list[i].begin <= list[i - 1].end) throw Malformed{};
    ranges = Ranges(std::move(list));
  }
  void operator()(Account& account) { take(&account, sizeof account); }

  bool at_end() const { return bytes_.empty(); }

 private:
  void take(void* to, std::size_t size) {
    if (size > bytes_.size()) throw Malformed{};
    if (size > 0) std::memcpy(to, bytes_.data(), size);
    bytes_.remove_prefix(size);
  }
  /// \return the size of a list with elements of at least `least` bytes.
  std::size_t size(std::size_t least) {
    std::uint64_t n = 0;
    (*this)(n);
    if (n > bytes_.size() / least) throw Malformed{};
    return static_cast<std::size_t>(n);
  }

  std::string_view bytes_;
};

/// \param part Partial or const Partial, `each` Unpacker or Packer
template <class P, class Each>
void for_each_value(P& part, Each& each) {
  auto& f = part.frame;
  const auto all = [&](auto&... values) { (each(values), ...); };
  all(f.scene_hash, f.arithmetic, f.seed, f.photons, f.samples, f.replicates, f.components,
      f.has_bounds, f.width, f.height, f.left, f.top, f.whole_width, f.whole_height, f.film_unit,
      f.exposure, f.groups, f.shot_power, f.unshot_power[0], f.unshot_power[1], f.unshot_power[2],
      f.cells, f.light_words, f.longest_path, f.warnings, f.dim_lights);
  auto& d = f.detectors;
  all(d.flux_u, d.flux_v, d.lengths, d.scatterings, d.angles, d.nx, d.ny, d.nz);
  all(part.matter_hash);
  for (auto& measured : part.measured) all(measured.done);
  auto& slice = part.slice;
  all(part.film.clamped, slice.replicate, slice.samples, slice.pixels, slice.film.clamped,
      slice.gathered);
  if constexpr (!std::is_const_v<P>) {
    if (f.replicates < 1 || f.replicates > most_replicates) throw Malformed{};
    part.replicates.resize(static_cast<std::size_t>(f.replicates));
  }
  for (auto& r : part.replicates) all(r.photons, r.shot, r.light_hash, r.samples, r.gathered);
}

/// Calls each(name, vector, count, element size [byte]) for the large arrays; each has `count`
/// values or none.
template <class P, class Each>
void for_each_array(P& part, const Each& each_array) {
  const Frame& f = part.frame;
  const auto each = [&](const std::string& name, auto& array, std::uint64_t count) {
    each_array(name, array, count, sizeof array[0]);
  };
  const std::uint64_t pixels = f.pixels(), groups = 3 * pixels * f.groups.size();
  for (std::size_t i = 0; i < part.replicates.size(); ++i) {
    auto& r = part.replicates[i];
    each(fmt::format("light {}", i), r.light, f.light_words);
    each(fmt::format("detected {}", i), r.detected, std::uint64_t{3 * f.detectors.count()});
    each(fmt::format("film {}", i), r.film, 3 * pixels);
  }
  each("film", part.film.pixels, pixels);
  each("groups", part.film.groups, groups);
  each("slice", part.slice.film.pixels, pixels);
  each("slice groups", part.slice.film.groups, groups);
  for (std::size_t m = 0; m < part.measured.size(); ++m) {
    const measurement::Row& row = measurement::rows[m];
    each_array(row.name, part.measured[m].words, f.count(m), row.element);
  }
}

void write_chunk(const std::string& name, std::string_view raw, OutputFile& file) {
  std::string stored(ZSTD_compressBound(raw.size()), '\0');
  const std::size_t size =
      ZSTD_compress(stored.data(), stored.size(), raw.data(), raw.size(), compression);
  if (ZSTD_isError(size)) throw std::bad_alloc();
  stored.resize(size);
  ChunkHeader header{{}, raw.size(), stored.size(), 0};
  std::memcpy(header.name, name.data(), std::min(name.size(), name_size));
  header.checksum = checksum(header, stored);
  file.write({reinterpret_cast<const char*>(&header), sizeof header});
  file.write(stored);
}

/// Reads the chunks of a file in order.
class Chunks {
 public:
  Chunks(std::string_view bytes, const std::string& path) : bytes_(bytes), path_(path) {
    std::uint32_t version = 0;
    if (bytes_.substr(0, magic.size()) != magic)
      fail("it is no part of a render (.tyn), or was cut at its beginning");
    bytes_.remove_prefix(magic.size());
    if (bytes_.size() < sizeof version) fail("it was cut at its beginning");
    std::memcpy(&version, bytes_.data(), sizeof version);
    bytes_.remove_prefix(sizeof version);
    if (version != part_version) {
      fail(
          fmt::format("its format is version {}, this program reads {}: use the version of "
                      "Tyndall that wrote it",
                      version, part_version));
    }
  }

  /// \return the name of the next chunk. \param[out] raw its bytes
  std::string next(std::string& raw) {
    ++index_;
    ChunkHeader header;
    if (bytes_.size() < sizeof header) damaged("it was cut there");
    std::memcpy(&header, bytes_.data(), sizeof header);
    bytes_.remove_prefix(sizeof header);
    name_.assign(header.name, ::strnlen(header.name, name_size));
    for (const char c : name_)
      if (c < ' ' || c > '~') damaged("its name is not printable");
    if (header.stored > bytes_.size()) damaged("it was cut there");
    const std::string_view stored = bytes_.substr(0, header.stored);
    bytes_.remove_prefix(header.stored);
    if (header.checksum != checksum(header, stored)) damaged("its checksum does not match");
    if (header.raw > most_in_chunk) damaged("it is too large");
    raw.resize(header.raw);
    const std::size_t size = ZSTD_decompress(raw.data(), raw.size(), stored.data(), stored.size());
    if (ZSTD_isError(size) || size != header.raw) damaged("it cannot be decompressed");
    return name_;
  }

  bool at_end() const { return bytes_.empty(); }

  [[noreturn]] void damaged(const std::string& why) const {
    fail(fmt::format("chunk {} ({}) is damaged: {}; make the file anew", index_,
                     name_.empty() ? "nameless" : name_, why));
  }
  [[noreturn]] void fail(const std::string& why) const {
    throw Error(ExitCode::input_missing, fmt::format("{}: {}", path_, why));
  }

 private:
  std::string_view bytes_;
  const std::string& path_;
  std::string name_;
  int index_ = 0;
};

/// \return whether the values are consistent, to be checked before the arrays are allocated.
bool is_sound(const Partial& part) {
  const Frame& f = part.frame;
  const Detectors& d = f.detectors;
  constexpr int most = 1 << 20;
  for (const int n : {f.width, f.height, f.whole_width, f.whole_height})
    if (n < 1 || n > most) return false;
  for (const int n : {d.flux_u, d.flux_v, d.lengths, d.scatterings, d.angles, d.nx, d.ny, d.nz})
    if (n < 0 || n > most) return false;
  if (f.components < 0 || f.components > max_components) return false;
  if (f.groups.size() > 4096) return false;
  if (f.light_words > std::uint64_t{1} << 40 || f.cells > f.light_words || f.samples == 0)
    return false;
  for (std::size_t m = 0; m < part.measured.size(); ++m)
    if (part.measured[m].done > f.count(m)) return false;
  if (part.slice.replicate >= f.replicates || part.slice.pixels > f.pixels()) return false;
  for (int i = 0; i < f.replicates; ++i) {
    const Replicate& r = part.replicates[static_cast<std::size_t>(i)];
    const auto within = [](const Ranges& ranges, IndexRange all) {
      return ranges.count() + ranges.missing(all).count() == all.end - all.begin;
    };
    if (!within(r.photons, f.photons_of(i)) || !within(r.samples, f.samples_of(i))) return false;
  }
  return true;
}

/// \return whether arrays that belong together are all present.
bool is_whole(const Partial& part) {
  bool has_samples = false;
  for (const Replicate& r : part.replicates) {
    if (r.samples.empty() != r.film.empty()) return false;
    if (r.photons.empty() && !r.light.empty()) return false;
    has_samples = has_samples || !r.samples.empty();
  }
  const auto has_groups = [&](const FilmTallies& film) {
    return film.groups.empty() == (film.pixels.empty() || part.frame.groups.empty());
  };
  for (const Measured& measured : part.measured)
    if (measured.words.empty() != (measured.done == 0)) return false;
  return has_samples != part.film.pixels.empty() && has_groups(part.film)
         && has_groups(part.slice.film);
}

}  // namespace

void write_part(const Partial& part, OutputFile& file) {
  file.write(magic);
  file.write({reinterpret_cast<const char*>(&part_version), sizeof part_version});
  Packer values;
  for_each_value(part, values);
  write_chunk("part", values.bytes(), file);
  for_each_array(part, [&](const std::string& name, const auto& array, std::uint64_t count,
                           std::size_t element) {
    std::string_view bytes(reinterpret_cast<const char*>(array.data()),
                           array.empty() ? 0 : count * element);
    for (; !bytes.empty(); bytes.remove_prefix(std::min(bytes.size(), most_in_chunk)))
      write_chunk(name, bytes.substr(0, most_in_chunk), file);
  });
  write_chunk("end", {}, file);
}

Partial parse_part(std::string_view bytes, const std::string& name, std::uint64_t most_bytes) {
  Chunks chunks(bytes, name);
  Partial part;
  std::string raw;
  if (chunks.next(raw) != "part") chunks.damaged("'part' was expected");
  try {
    Unpacker values(raw);
    for_each_value(part, values);
    if (!values.at_end() || !is_sound(part)) throw Malformed{};
  } catch (const Malformed&) {
    chunks.damaged("its values are invalid");
  }
  std::uint64_t left = most_bytes;
  std::string next = chunks.next(raw);
  for_each_array(part, [&](const std::string& array_name, auto& array, std::uint64_t count,
                           std::size_t element) {
    if (next != array_name) return;
    if (count > left / element) {
      throw Error(
          ExitCode::out_of_memory,
          fmt::format("{}: its {} needs {:.3g} GiB more memory than there is", name, array_name,
                      (static_cast<double>(count) * static_cast<double>(element)
                       - static_cast<double>(left))
                          / 0x1p30));
    }
    left -= count * element;
    std::uint64_t filled = 0;
    for (; next == array_name; next = chunks.next(raw)) {
      if (raw.size() > count * element - filled) chunks.damaged("it has too many values");
      if (filled == 0) array.resize((count * element + sizeof array[0] - 1) / sizeof array[0]);
      std::memcpy(reinterpret_cast<char*>(array.data()) + filled, raw.data(), raw.size());
      filled += raw.size();
    }
    if (filled != count * element) chunks.damaged(fmt::format("'{}' lacks values", array_name));
  });
  if (next != "end") chunks.damaged("it is not expected there");
  if (!chunks.at_end()) chunks.damaged("bytes follow the end");
  if (!is_whole(part)) chunks.damaged("arrays are missing before it");
  return part;
}

Partial read_part(const std::string& path, std::uint64_t most_bytes) {
  const auto fail = [&](const char* step) {
    throw Error(ExitCode::input_missing,
                fmt::format("{}: {}: {}", path, step, std::generic_category().message(errno)));
  };
  struct Descriptor {
    int number;
    ~Descriptor() {
      if (number >= 0) ::close(number);
    }
  } const file{::open(path.c_str(), O_RDONLY | O_CLOEXEC)};
  if (file.number < 0) fail("cannot be opened");
  struct stat status {};
  if (::fstat(file.number, &status) != 0) fail("cannot be examined");
  if (!S_ISREG(status.st_mode))
    throw Error(ExitCode::input_missing, fmt::format("{}: is no regular file", path));
  std::string bytes(static_cast<std::size_t>(status.st_size), '\0');
  for (std::size_t filled = 0; filled < bytes.size();) {
    const ssize_t got = ::read(file.number, bytes.data() + filled, bytes.size() - filled);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) fail("cannot be read");
    if (got == 0) bytes.resize(filled);  // the file has become shorter
    filled += static_cast<std::size_t>(got);
  }
  return parse_part(bytes, path, most_bytes);
}

}  // namespace tyndall::io
