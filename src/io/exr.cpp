#include "io/exr.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <exception>
#include <filesystem>

#include <ImfChannelList.h>
#include <ImfChromaticities.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>
#include <fmt/format.h>

#include "io/exr_header.h"
#include "tyndall/render/error.h"

namespace tyndall::io {
namespace {

constexpr const char* channels[] = {"R", "G", "B", "A"};

/// A seekable file in memory: OpenEXR fills in its table of offsets at the end.
class MemoryStream final : public Imf::OStream {
 public:
  MemoryStream() : OStream("memory") {}

  void write(const char bytes[], int count) override {
    const auto size = static_cast<std::size_t>(count);
    bytes_.resize(std::max(bytes_.size(), position_ + size));
    std::memcpy(bytes_.data() + position_, bytes, size);
    position_ += size;
  }
  std::uint64_t tellp() override { return position_; }
  void seekp(std::uint64_t position) override { position_ = position; }

  std::string take() { return std::move(bytes_); }

 private:
  std::string bytes_;
  std::size_t position_ = 0;
};

/// \param rgba `width` pixels per row; the first is the corner (left, top) of the data window
Imf::FrameBuffer frame_buffer(float* rgba, int width, int left = 0, int top = 0) {
  constexpr std::size_t pixel = 4 * sizeof(float);
  const std::size_t row = pixel * static_cast<std::size_t>(width);
  Imf::FrameBuffer buffer;
  for (int c = 0; c < 4; ++c) {
    // OpenEXR expects the address of pixel (0, 0), which may lie outside the array. The arithmetic
    // uses integers, because out-of-range pointers are undefined.
    const std::uintptr_t origin = reinterpret_cast<std::uintptr_t>(rgba + c)
                                  - static_cast<std::uintptr_t>(left) * pixel
                                  - static_cast<std::uintptr_t>(top) * row;
    buffer.insert(channels[c], Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(origin), pixel, row));
  }
  return buffer;
}

/// Adds the channels of a layer as "layer.X". \param left, top as for frame_buffer()
void add_layer(Imf::FrameBuffer& buffer, const PictureLayer& layer, int width, int left = 0,
               int top = 0) {
  const std::size_t pixel = layer.channels.size() * sizeof(float);
  const std::size_t row = pixel * static_cast<std::size_t>(width);
  for (std::size_t c = 0; c < layer.channels.size(); ++c) {
    const std::uintptr_t origin = reinterpret_cast<std::uintptr_t>(layer.values.data() + c)
                                  - static_cast<std::uintptr_t>(left) * pixel
                                  - static_cast<std::uintptr_t>(top) * row;
    buffer.insert(fmt::format("{}.{}", layer.name, layer.channels[c]),
                  Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(origin), pixel, row));
  }
}

/// \return the layers of a file, without values.
std::vector<PictureLayer> layers_of(const Imf::Header& header) {
  std::vector<PictureLayer> layers;
  for (auto it = header.channels().begin(); it != header.channels().end(); ++it) {
    const std::string name = it.name();
    const std::size_t dot = name.rfind('.');
    if (dot == name.npos || dot + 2 != name.size()) continue;
    const std::string layer = name.substr(0, dot);
    if (layers.empty() || layers.back().name != layer) layers.push_back({layer, "", {}});
    layers.back().channels += name[dot + 1];
  }
  for (PictureLayer& layer : layers)
    if (layer.channels == "BGR") layer.channels = "RGB";  // files sort channels by name
  return layers;
}

}  // namespace

std::string encode_exr(const Picture& picture) {
  const auto window = [](int left, int top, int width, int height) {
    return Imath::Box2i({left, top}, {left + width - 1, top + height - 1});
  };
  const bool is_whole = picture.whole_width == 0;
  const auto data = window(picture.left, picture.top, picture.width, picture.height);
  Imf::Header header(is_whole ? data : window(0, 0, picture.whole_width, picture.whole_height),
                     data);
  header.compression() = Imf::ZIP_COMPRESSION;
  // OpenEXR's slices are not const, but writing a file only reads them.
  Imf::FrameBuffer buffer = frame_buffer(const_cast<float*>(picture.rgba.data()), picture.width,
                                         picture.left, picture.top);
  for (const PictureLayer& layer : picture.layers)
    add_layer(buffer, layer, picture.width, picture.left, picture.top);
  for (auto slice = buffer.begin(); slice != buffer.end(); ++slice)
    header.channels().insert(slice.name(), Imf::Channel(Imf::FLOAT));
  Imf::addChromaticities(header, Imf::Chromaticities());  // the default is Rec. 709 with D65
  for (const auto& [key, value] : picture.provenance)
    header.insert(key, Imf::StringAttribute(value));

  MemoryStream stream;
  {
    Imf::OutputFile file(stream, header);
    file.setFrameBuffer(buffer);
    file.writePixels(picture.height);
  }  // writes the table of offsets
  return stream.take();
}

Picture read_exr(const std::string& path) {
  if (const std::string problem = exr_header_problem(path); !problem.empty())
    throw Error(ExitCode::input_missing, fmt::format("{}: {}", path, problem));
  try {
    Imf::InputFile file(path.c_str());
    const Imf::Header& header = file.header();
    for (const char* channel : channels)
      if (header.channels().findChannel(channel) == nullptr)
        throw Error(ExitCode::input_missing, fmt::format("{}: has no channel {}", path, channel));

    const auto &window = header.dataWindow(), &whole = header.displayWindow();
    // Images have this limit, too (DecodedImage::resize() in io/helper/images.cpp).
    const auto pixels = (double{1} * window.max.x - window.min.x + 1)
                        * (double{1} * window.max.y - window.min.y + 1);
    if (pixels / 2000 > static_cast<double>(std::filesystem::file_size(path)))
      throw Error(ExitCode::input_missing,
                  fmt::format("{}: damaged: claims {} pixels", path, pixels));
    Picture picture;
    picture.width = window.max.x - window.min.x + 1;
    picture.height = window.max.y - window.min.y + 1;
    picture.left = window.min.x - whole.min.x;
    picture.top = window.min.y - whole.min.y;
    picture.whole_width = whole.max.x - whole.min.x + 1;
    picture.whole_height = whole.max.y - whole.min.y + 1;
    picture.rgba.resize(4 * static_cast<std::size_t>(picture.width)
                        * static_cast<std::size_t>(picture.height));
    Imf::FrameBuffer buffer =
        frame_buffer(picture.rgba.data(), picture.width, window.min.x, window.min.y);
    picture.layers = layers_of(header);
    for (PictureLayer& layer : picture.layers) {
      layer.values.resize(picture.rgba.size() / 4 * layer.channels.size());
      add_layer(buffer, layer, picture.width, window.min.x, window.min.y);
    }
    file.setFrameBuffer(buffer);
    file.readPixels(window.min.y, window.max.y);
    for (auto it = header.begin(); it != header.end(); ++it) {
      const auto* text = dynamic_cast<const Imf::StringAttribute*>(&it.attribute());
      const std::string key = it.name();
      if (text != nullptr && key.rfind("tyndall.", 0) == 0)
        picture.provenance.emplace_back(key, text->value());
    }
    return picture;
  } catch (const Error&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    throw Error(ExitCode::input_missing, fmt::format("{}: cannot be read: {}", path, error.what()));
  }
}

}  // namespace tyndall::io
