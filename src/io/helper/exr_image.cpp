// The colours of OpenEXR files: selects the part and layer, and applies the header's metadata.
#include <algorithm>
#include <cstdint>
#include <exception>
#include <map>
#include <memory>

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputPart.h>
#include <ImfMultiPartInputFile.h>
#include <ImfPartType.h>
#include <ImfRgbaFile.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "io/exr_header.h"
#include "io/helper/decoded_image.h"

namespace tyndall::io {
namespace {

std::string lower(std::string text) {
  for (char& c : text)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return text;
}

/// The channels of one picture.
struct Layer {
  enum class Kind { rgb, grey, luminance_chroma };
  Kind kind = Kind::rgb;
  int part = 0;
  std::string part_name, name;  ///< `name`: the prefix of its channels, without the dot
  std::string channel[3] = {};  ///< red, green and blue

  /// \return "beauty", or "part 1 'rgba'".
  std::string shown(bool has_parts) const {
    std::string text = has_parts ? fmt::format("part {} '{}'", part, part_name) : "";
    if (!name.empty()) text += (text.empty() ? "" : ", ") + name;
    return text.empty() ? "R, G, B" : text;
  }
};

/// \return whether renderers use this name for the final picture, not for one of its components.
bool is_main(const std::string& name) {
  const std::string last = lower(name.substr(name.rfind('.') + 1));
  constexpr const char* names[] = {"",         "rgb",       "rgba",  "beauty",
                                   "combined", "composite", "color", "colour"};
  return std::find(std::begin(names), std::end(names), last) != std::end(names);
}

/// \return 0, 1 or 2 for red, green or blue, -1 for other channels.
int color_of(const std::string& channel) {
  const std::string c = lower(channel);
  if (c == "r" || c == "red") return 0;
  if (c == "g" || c == "green") return 1;
  return c == "b" || c == "blue" ? 2 : -1;
}

std::vector<std::string> channels_of(const Imf::Header& header) {
  std::vector<std::string> names;
  for (auto c = header.channels().begin(); c != header.channels().end(); ++c)
    names.emplace_back(c.name());
  return names;
}

bool is_deep(const Imf::Header& header) {
  return header.hasType() && Imf::isDeepData(header.type());
}

/// \return the colour layers of a part, or else its grey layer if it has one.
std::vector<Layer> layers_of(const Imf::Header& header, int part) {
  const std::string part_name = header.hasName() ? header.name() : "";
  std::map<std::string, Layer> layers;
  const std::vector<std::string> channels = channels_of(header);
  for (const std::string& channel : channels) {
    const std::size_t dot = channel.rfind('.');
    const std::string name = dot == channel.npos ? "" : channel.substr(0, dot);
    const int color = color_of(dot == channel.npos ? channel : channel.substr(dot + 1));
    if (color < 0) continue;
    Layer& layer = layers[name];
    layer.part = part;
    layer.part_name = part_name;
    layer.name = name;
    layer.channel[color] = channel;
  }
  std::vector<Layer> found;
  for (const auto& [name, layer] : layers)
    if (std::none_of(std::begin(layer.channel), std::end(layer.channel),
                     [](const std::string& c) { return c.empty(); }))
      found.push_back(layer);
  if (!found.empty()) return found;

  const auto has = [&](const std::string& name) {
    return std::find(channels.begin(), channels.end(), name) != channels.end();
  };
  Layer layer;
  layer.part = part;
  layer.part_name = part_name;
  if (has("Y") && has("RY") && has("BY")) {
    layer.kind = Layer::Kind::luminance_chroma;
    return {layer};
  }
  layer.kind = Layer::Kind::grey;
  for (const std::string& grey : {std::string("Y"), std::string("L")}) {
    if (!has(grey) || has("X")) continue;  // X, Y, Z are positions, for example
    for (std::string& c : layer.channel) c = grey;
    return {layer};
  }
  if (channels.size() == 1 && color_of(channels[0]) >= 0) {
    for (std::string& c : layer.channel) c = channels[0];
    return {layer};
  }
  return {};
}

/// \return the layer to read, or null if the choice is ambiguous. \param[out] problem the reason
const Layer* choose(const std::vector<Layer>& layers, bool has_parts, std::string& problem) {
  const auto only = [&](const auto& fits) -> const Layer* {
    const auto is_it = [&](const Layer& layer) { return fits(layer); };
    if (std::count_if(layers.begin(), layers.end(), is_it) != 1) return nullptr;
    return &*std::find_if(layers.begin(), layers.end(), is_it);
  };
  const auto is_plain = [&](const Layer& l) { return l.name.empty() && is_main(l.part_name); };
  if (!has_parts)
    if (const Layer* plain = only([](const Layer& l) { return l.name.empty(); })) return plain;
  if (const Layer* plain = only(is_plain)) return plain;
  const auto is_beauty = [](const Layer& l) {
    return is_main(l.name) && (!l.name.empty() || is_main(l.part_name));
  };
  if (const Layer* beauty = only(is_beauty)) return beauty;
  if (layers.size() == 1) return &layers[0];
  if (layers.empty()) {
    problem = "it has no colours: no channels R, G, B, and no Y";
    return nullptr;
  }
  std::vector<std::string> names;
  for (const Layer& layer : layers)
    if (names.size() < 20) names.push_back(layer.shown(has_parts));
  const Layer& first = layers[0];
  problem = fmt::format(
      "{} of its layers could be the sky: {}{}; write the intended one into its own file, for "
      "example with `oiiotool sky.exr{} --ch {} -o one.exr`",
      layers.size(), fmt::join(names, "; "), layers.size() > names.size() ? "; ..." : "",
      has_parts ? fmt::format(" --subimage {}", first.part) : "", fmt::join(first.channel, ","));
  return nullptr;
}

/// Reads the channels of `layer` into the red, green and blue floats of the pixels.
void read_channels(Imf::MultiPartInputFile& file, const Layer& layer, DecodedImage& image) {
  Imf::InputPart part(file, layer.part);
  const Imath::Box2i& window = part.header().dataWindow();
  constexpr std::size_t pixel = 3 * sizeof(float);
  const std::size_t row = pixel * static_cast<std::size_t>(image.width);
  const bool is_grey = layer.kind == Layer::Kind::grey;
  Imf::FrameBuffer buffer;
  for (int c = 0; c < (is_grey ? 1 : 3); ++c) {
    const Imf::Channel* channel = part.header().channels().findChannel(layer.channel[c]);
    if (channel->xSampling != 1 || channel->ySampling != 1)
      throw Failure{error_choice,
                    fmt::format("channel {} holds only every {}th column and {}th "
                                "row",
                                layer.channel[c], channel->xSampling, channel->ySampling)};
    // OpenEXR expects the address of pixel (0, 0), which may lie outside the array. The arithmetic
    // uses integers, because out-of-range pointers are undefined.
    const std::uintptr_t origin = reinterpret_cast<std::uintptr_t>(image.rgb.data() + c)
                                  - static_cast<std::uintptr_t>(window.min.x) * pixel
                                  - static_cast<std::uintptr_t>(window.min.y) * row;
    buffer.insert(layer.channel[c],
                  Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(origin), pixel, row));
  }
  part.setFrameBuffer(buffer);
  part.readPixels(window.min.y, window.max.y);
  if (is_grey)
    for (std::size_t i = 0; i < image.rgb.size(); i += 3)
      image.rgb[i + 1] = image.rgb[i + 2] = image.rgb[i];
}

/// Reads luminance at every pixel and chroma at every fourth; OpenEXR reconstructs the colours.
void read_luminance_chroma(bool has_parts, DecodedImage& image) {
  if (has_parts)
    throw Failure{error_choice,
                  "luminance and chroma (Y, RY, BY) are read only from a file of one "
                  "part"};
  Imf::RgbaInputFile file(input_path, 0);
  const Imath::Box2i& window = file.dataWindow();
  const auto width = static_cast<std::size_t>(image.width);
  std::vector<Imf::Rgba> row(width);
  float* out = image.rgb.data();
  for (int y = window.min.y; y <= window.max.y; ++y) {
    // As above: OpenEXR expects the address of pixel (0, 0).
    const std::uintptr_t origin = reinterpret_cast<std::uintptr_t>(row.data())
                                  - static_cast<std::uintptr_t>(window.min.x) * sizeof(Imf::Rgba);
    file.setFrameBuffer(reinterpret_cast<Imf::Rgba*>(origin), 1, 0);
    file.readPixels(y);
    for (const Imf::Rgba& p : row)
      for (const float c : {float(p.r), float(p.g), float(p.b)}) *out++ = c;
  }
}

std::vector<int> corners(const Imath::Box2i& box) {
  return {box.min.x, box.min.y, box.max.x, box.max.y};
}

std::string compression_of(const Imf::Header& header) {
  constexpr const char* names[] = {"none",  "rle", "zips", "zip",  "piz",
                                   "pxr24", "b44", "b44a", "dwaa", "dwab"};
  const auto n = static_cast<std::size_t>(header.compression());
  return n < std::size(names) ? names[n] : "unknown";
}

/// Adds the metadata of a part to `out`. \param envmap the part's attribute, or null
void describe_part(const Imf::Header& header, const int* envmap, Json& out) {
  if (header.hasName()) out["name"] = header.name();
  if (header.hasView()) out["view"] = header.view();
  if (is_deep(header)) out["deep"] = true;
  out["channels"] = fmt::format("{}", fmt::join(channels_of(header), ", "));
  out["data window"] = corners(header.dataWindow());
  out["display window"] = corners(header.displayWindow());
  out["compression"] = compression_of(header);
  if (header.pixelAspectRatio() != 1) out["pixel aspect ratio"] = header.pixelAspectRatio();
  if (envmap != nullptr) {
    if (*envmap == Imf::ENVMAP_LATLONG)
      out["envmap"] = "latlong";
    else if (*envmap == Imf::ENVMAP_CUBE)
      out["envmap"] = "cube";
    else
      out["envmap"] = *envmap;
  }
  for (auto it = header.begin(); it != header.end(); ++it) {
    const auto* text = dynamic_cast<const Imf::StringAttribute*>(&it.attribute());
    if (text != nullptr && std::string(it.name()).starts_with("tyndall."))
      out[it.name()] = text->value();
  }
}

/// Applies the header of the chosen part to the image, and warns about metadata that is ignored.
void apply_header(const Imf::Header& header, DecodedImage& image) {
  const auto size = [](int low, int high) { return static_cast<long long>(high) - low + 1; };
  const Imath::Box2i &data = header.dataWindow(), &whole = header.displayWindow();
  const long long width = size(whole.min.x, whole.max.x), height = size(whole.min.y, whole.max.y);
  static constexpr long long most = 1 << 28;
  if (width > most || height > most || width * height > most)
    damaged(fmt::format("its display window has {} x {} pixels", width, height));
  image.whole_width = static_cast<int>(width);
  image.whole_height = static_cast<int>(height);
  const auto offset = [](int a, int b) {
    return static_cast<int>(std::clamp<long long>(static_cast<long long>(a) - b, -most, most));
  };
  image.left = offset(data.min.x, whole.min.x);
  image.top = offset(data.min.y, whole.min.y);
  if (Imf::hasChromaticities(header)) {
    const Imf::Chromaticities& c = Imf::chromaticities(header);
    image.primaries =
        Primaries{{double{c.red.x}, double{c.red.y}, double{c.green.x}, double{c.green.y},
                   double{c.blue.x}, double{c.blue.y}, double{c.white.x}, double{c.white.y}}};
  }
  if (header.pixelAspectRatio() != 1)
    image.warnings.push_back(fmt::format("its pixelAspectRatio of {:g} is not applied: {}",
                                         header.pixelAspectRatio(), whole_sphere));
  if (Imf::hasWhiteLuminance(header))
    image.warnings.push_back(
        fmt::format("its whiteLuminance of {:g} cd/m2 is not applied: values "
                    "count as radiance",
                    Imf::whiteLuminance(header)));
  if (Imf::hasAdoptedNeutral(header))
    image.warnings.push_back("its adoptedNeutral is not applied: white is that of its primaries");
}

DecodedImage decode() {
  DecodedImage image;
  Imf::MultiPartInputFile file(input_path, 0);
  const bool has_parts = file.parts() > 1;
  const std::map<std::size_t, int> envmaps = exr_envmaps(input_path);
  const auto envmap_of = [&](int part) -> const int* {
    const auto found = envmaps.find(static_cast<std::size_t>(part));
    return found == envmaps.end() ? nullptr : &found->second;
  };
  std::vector<Layer> layers, greys;
  for (int n = 0; n < file.parts(); ++n) {
    const Imf::Header& header = file.header(n);
    Json part = Json::object();
    describe_part(header, envmap_of(n), part);
    if (has_parts)
      image.told["parts"].push_back(part);
    else
      image.told.update(part);
    if (is_deep(header)) continue;
    for (const Layer& layer : layers_of(header, n))
      (layer.kind == Layer::Kind::grey ? greys : layers).push_back(layer);
  }
  if (layers.empty()) layers = greys;
  const Layer* layer = choose(layers, has_parts, image.problem);
  if (layer == nullptr) {
    if (layers.empty()) {
      std::vector<std::string> all;
      for (int n = 0; n < file.parts(); ++n)
        for (const std::string& c : channels_of(file.header(n)))
          if (all.size() < 30) all.push_back(c);
      image.problem += fmt::format("; its channels: {}", fmt::join(all, ", "));
    }
    return image;
  }
  if (has_parts || !layer->name.empty()) image.told["taken"] = layer->shown(has_parts);
  const Imf::Header& header = file.header(layer->part);
  const int* envmap = envmap_of(layer->part);
  if (envmap != nullptr && *envmap == Imf::ENVMAP_CUBE) {
    image.problem =
        "a cube map of six faces (envmap): convert it to longitude and latitude, for example with "
        "`exrenvmap -l`";
    return image;
  }
  if (envmap != nullptr && *envmap != Imf::ENVMAP_LATLONG) {
    image.problem = fmt::format(
        "its envmap is {}, neither 0 (latlong) nor 1 (a cube): convert it to longitude and "
        "latitude, with envmap 0 or without",
        *envmap);
    return image;
  }
  apply_header(header, image);
  const Imath::Box2i& data = header.dataWindow();
  image.resize(static_cast<long long>(data.max.x) - data.min.x + 1,
               static_cast<long long>(data.max.y) - data.min.y + 1);
  if (layer->kind == Layer::Kind::luminance_chroma)
    read_luminance_chroma(has_parts, image);
  else
    read_channels(file, *layer, image);
  return image;
}

}  // namespace

DecodedImage decode_exr() {
  if (const std::string problem = exr_header_problem(input_path); !problem.empty())
    damaged(problem.starts_with("damaged: ") ? problem.substr(9) : problem);
  return decode();
}

}  // namespace tyndall::io
