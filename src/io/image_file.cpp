#include "io/image_file.h"

#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <utility>

#include <fmt/format.h>

#include "io/helper/protocol.h"
#include "io/reader_process.h"
#include "tyndall/render/error.h"

namespace tyndall::io {
namespace {

/// \return the image that the helper wrote to the memory file.
std::shared_ptr<const Image> adopt(const std::string& path, const Descriptor& memory,
                                   const Json& image) {
  const int width = image.value("width", 0), height = image.value("height", 0);
  const auto texels = static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height);
  static_assert(sizeof(Vec3f) == 3 * sizeof(float));
  const std::uint64_t size = texels * sizeof(Vec3f);
  if (width < 1 || height < 1 || memory.size() != size)
    fail_reading(path, "damaged: reading it returned no image");
  std::vector<Vec3f> values(texels);
  for (std::uint64_t done = 0; done < size;) {
    const ssize_t n = ::pread(memory.number(), reinterpret_cast<char*>(values.data()) + done,
                              size - done, static_cast<off_t>(done));
    if (n <= 0) fail_reading(path, "damaged: the image that its reader returned cannot be read");
    done += static_cast<std::uint64_t>(n);
  }
  if (image.value("checksum", "") != checksum(values.data(), size))
    fail_reading(path, "damaged: the image that its reader returned has a wrong checksum");
  return std::make_shared<const Image>(width, height, std::move(values));
}

}  // namespace

LoadedImage read_image_file(const std::string& path) {
#if !TYNDALL_READS_IMAGES
  fail_reading(path, "this build reads no images: it was made without OpenEXR and OpenImageIO");
#endif
  const Descriptor file = open_input(path), memory = memory_file(path);
  const Json report = call_helper(path, file, memory, {"image"});
  if (report.contains("error")) {
    const std::string kind = report.value("error", ""), message = report.value("message", "");
    if (kind == error_memory) fail_reading(path, "damaged, or too large: " + message);
    fail_reading(path, (kind == error_damaged ? "damaged: " : "") + cut(message, 600));
  }
  LoadedImage loaded;
  loaded.told = report.value("told", Json::object());
  loaded.warnings = report.value("warnings", std::vector<std::string>());
  loaded.problem = report.value("problem", "");
  if (loaded.problem.empty())
    loaded.image = adopt(path, memory, report.value("image", Json::object()));
  return loaded;
}

LoadedImage load_image(const std::string& path) {
  LoadedImage loaded = read_image_file(path);
  if (!loaded.problem.empty()) fail_reading(path, loaded.problem);
  return loaded;
}

}  // namespace tyndall::io
