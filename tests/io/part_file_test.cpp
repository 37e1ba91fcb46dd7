/// \file
/// A part is read from a file exactly as it was written, or it is refused.
#if TYNDALL_ZSTD
#include "io/part_file.h"

#include <gtest/gtest.h>

#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "support/scenes.h"
#include "tyndall/render/error.h"

namespace tyndall::test {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t much = std::uint64_t{1} << 32;

class PartFile : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = fs::temp_directory_path() / "tyndall-XXXXXX";
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  void TearDown() override { fs::remove_all(folder_); }

  /// \return a render interrupted during its samples, which has all that a part can hold.
  Partial checkpoint() const {
    Scene scene = coloured();
    scene.photons = 300;
    scene.samples = 9;
    scene.illumination_resolution = {3, 3, 3};
    scene.camera.resolution = {6, 5};
    scene.detectors.flux = {2, 2};
    scene.detectors.path_length_bins = 4;
    scene.detectors.path_length_max = 8;
    RenderOptions options;
    options.batch = 16;
    options.go_on = [](Renderer& r, Moment moment) {
      const Partial& part = r.part();
      return moment != Moment::batch || part.samples().count() < 4 || part.slice.pixels == 0;
    };
    const auto backend = make_cpu_backend(1);
    Renderer renderer(scene, *backend, options);
    EXPECT_FALSE(renderer.run());
    return renderer.part();
  }

  std::string write(const Partial& part) const {
    const std::string path = folder_ / "a.tyn";
    io::OutputFile file(path);
    io::write_part(part, file);
    file.commit();
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }

  fs::path folder_;
};

/// \return the error of reading the bytes, empty if they are accepted.
std::string refusal(const std::string& bytes, std::uint64_t most = much,
                    ExitCode code = ExitCode::input_missing) {
  try {
    io::parse_part(bytes, "a.tyn", most);
    return "";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), code) << error.what();
    EXPECT_EQ(std::string(error.what()).find("a.tyn: "), 0u) << error.what();
    return error.what();
  }
}

TEST_F(PartFile, of_a_render_interrupted_at_once_is_whole) {
  const Scene scene = quick();
  RenderOptions options;
  std::atomic<bool> has_bounds = false;  // then comes a signal, sooner than the first cell
  options.progress = [&](const Progress& p) { has_bounds = std::string(p.pass) != "bounds"; };
  options.stop = [&] { return has_bounds.load(); };
  options.go_on = [](Renderer&, Moment) { return false; };
  const auto backend = make_cpu_backend(1);
  Renderer renderer(scene, *backend, options);
  EXPECT_FALSE(renderer.run());
  const Partial part = io::parse_part(write(renderer.part()), "a.tyn", 1 << 20);
  EXPECT_EQ(part.measured[measurement::scattering].done, 0u);
  EXPECT_TRUE(part.samples().empty());
}

TEST_F(PartFile, comes_back_as_it_was) {
  const Partial part = checkpoint();
  ASSERT_GE(part.slice.replicate, 0);
  ASSERT_GT(part.slice.pixels, 0u);
  const std::string bytes = write(part);
  const Partial read = io::read_part(folder_ / "a.tyn", much);
  EXPECT_EQ(write(read), bytes);
  EXPECT_EQ(hash_tallies(read), hash_tallies(part));
  EXPECT_EQ(read.frame.groups, part.frame.groups);
  EXPECT_EQ(read.slice.pixels, part.slice.pixels);
  EXPECT_EQ(read.measured[measurement::depth].words, part.measured[measurement::depth].words);
}

TEST_F(PartFile, with_any_byte_changed_is_refused_and_names_the_chunk) {
  std::string bytes = write(checkpoint());
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    for (const char flip : {'\x01', '\x80'}) {
      bytes[i] = static_cast<char>(bytes[i] ^ flip);
      const std::string message = refusal(bytes);
      ASSERT_NE(message, "") << "byte " << i;
      ASSERT_EQ(message.find("chunk ") != std::string::npos, i >= 12) << message;
      bytes[i] = static_cast<char>(bytes[i] ^ flip);
    }
  }
  EXPECT_EQ(refusal(bytes), "");
}

TEST_F(PartFile, of_any_length_but_its_own_is_refused) {
  const std::string bytes = write(checkpoint());
  for (std::size_t size = 0; size < bytes.size(); ++size)
    ASSERT_NE(refusal(bytes.substr(0, size)), "") << size;
  EXPECT_NE(refusal(bytes + '\0').find("bytes follow the end"), std::string::npos);
}

TEST_F(PartFile, of_another_version_is_refused) {
  std::string bytes = write(checkpoint());
  bytes[8] = 77;
  EXPECT_NE(refusal(bytes).find("version 77, this program reads 3"), std::string::npos);
}

TEST_F(PartFile, that_needs_too_much_memory_is_refused) {
  EXPECT_NE(refusal(write(checkpoint()), 1000, ExitCode::out_of_memory).find("more memory"),
            std::string::npos);
}

TEST_F(PartFile, is_no_folder_and_must_be_there) {
  EXPECT_THROW(io::read_part(folder_, much), Error);
  EXPECT_THROW(io::read_part(folder_ / "none.tyn", much), Error);
}

}  // namespace
}  // namespace tyndall::test
#endif
