// Parts of renders. An input is an uncompressed part: chunks of a name (16 bytes), a length (8) and
// as many bytes. The target adds the header and valid checksums; otherwise no input would get past
// them. Inputs that begin like a file are used unchanged.
#include "io/part_file.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <algorithm>
#include <cstring>
#include <fstream>

#include <zstd.h>

#include "fuzz/fuzz.h"
#include "support/scenes.h"

namespace {

constexpr std::size_t name_size = 16, header = name_size + 8;

std::uint64_t number_at(const std::string& bytes, std::size_t at) {
  std::uint64_t n = 0;
  std::memcpy(&n, &bytes[at], 8);
  return n;
}

std::string number(std::uint64_t n) { return {reinterpret_cast<const char*>(&n), 8}; }

std::string packed(const std::string& chunks) {
  std::string file("TYNPART\n\2\0\0\0", 12);
  for (std::size_t at = 0; at + header <= chunks.size();) {
    const std::size_t raw =
        std::min<std::uint64_t>(number_at(chunks, at + name_size), chunks.size() - at - header);
    std::string stored(ZSTD_compressBound(raw), '\0');
    stored.resize(ZSTD_compress(stored.data(), stored.size(), &chunks[at + header], raw, 1));
    const std::string begin = chunks.substr(at, name_size) + number(raw) + number(stored.size());
    const std::string all = begin + stored;
    file += begin + number(XXH3_64bits(all.data(), all.size())) + stored;
    at += header + raw;
  }
  return file;
}

std::string unpacked(const std::string& file) {
  std::string chunks;
  for (std::size_t at = 12; at + 40 <= file.size();) {
    const std::uint64_t raw = number_at(file, at + 16), stored = number_at(file, at + 24);
    std::string content(raw, '\0');
    ZSTD_decompress(content.data(), raw, &file[at + 40], stored);
    chunks += file.substr(at, name_size) + number(raw) + content;
    at += 40 + stored;
  }
  return chunks;
}

tyndall::Scene small_scene() {
  tyndall::Scene scene = tyndall::test::coloured();
  scene.photons = 40;
  scene.samples = 9;
  scene.illumination_resolution = {2, 2, 2};
  scene.camera.resolution = {3, 2};
  scene.detectors.flux = {1, 1};
  return scene;
}

tyndall::Partial rendered(const tyndall::RenderOptions& options) {
  using namespace tyndall;
  const Scene scene = small_scene();
  const auto backend = make_cpu_backend(1);
  Renderer renderer(scene, *backend, options);
  renderer.run();
  return renderer.part();
}

/// \return a part of a render interrupted during its samples.
std::string checkpoint() {
  using namespace tyndall;
  RenderOptions options;
  options.batch = 2;
  options.go_on = [](Renderer& r, Moment) {
    return r.part().samples().count() < 4 || r.part().slice.pixels == 0;
  };
  const std::string path = "/tmp/tyndall-fuzz-seed.tyn";
  io::OutputFile file(path);
  io::write_part(rendered(options), file);
  file.commit();
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// \return the remaining samples of the render that the seeds began.
const tyndall::Partial& the_rest() {
  static const tyndall::Partial rest = [] {
    tyndall::RenderOptions options;
    options.samples = {4, 9};
    return rendered(options);
  }();
  return rest;
}

}  // namespace

/// Writes a seed to the folder that TYNDALL_FUZZ_SEEDS names.
extern "C" int LLVMFuzzerInitialize(int*, char***) {
  the_rest();  // rendered before the time limit per input applies
  if (const char* folder = std::getenv("TYNDALL_FUZZ_SEEDS")) {
    const std::string file = checkpoint();
    std::ofstream(std::string(folder) + "/file", std::ios::binary) << file;
    std::ofstream(std::string(folder) + "/chunks", std::ios::binary) << unpacked(file);
  }
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace tyndall;
  return fuzz::expect_an_error_at_most([&] {
    std::string input(reinterpret_cast<const char*>(bytes), size);
    if (!input.starts_with("TYNPART\n")) input = packed(input);
    Partial part = io::parse_part(input, "part", std::uint64_t{256} << 20);
    if (!part.film.pixels.empty()) develop(part);
    hash_tallies(part);
    merge(part, "part", the_rest(), "rest");
    develop(part);
    without_light(std::move(part));
  });
}
