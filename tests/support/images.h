/// \file
/// Writes image files byte by byte, without the libraries that read them.
#pragma once

#include <array>
#include <functional>
#include <string>
#include <vector>

namespace tyndall::test {

struct ExrChannel {
  std::string name;
  std::function<float(int x, int y)> value;  ///< of a pixel of the data window
  int sampling = 1;                          ///< stride of the stored rows and columns
};

struct ExrPart {
  std::vector<ExrChannel> channels;
  std::array<int, 4> data{0, 0, 15, 7};     ///< window: the first and the last column and row
  std::array<int, 4> display{0, 0, 15, 7};  ///< window
  std::string attributes = {};              ///< see exr_attribute
  std::string name = {};                    ///< required if there are several parts
  float pixel_aspect = 1;
};

/// \return the channels R, G and B of a layer; "": without a layer name.
std::vector<ExrChannel> exr_rgb(const std::string& layer, float red, float green, float blue);

/// \param value the bytes of the attribute, little endian
std::string exr_attribute(const std::string& name, const std::string& type,
                          const std::string& value);
std::string bytes_of(const std::vector<float>& values);

/// An OpenEXR file of floats, uncompressed, by rows.
std::string exr_file(const std::vector<ExrPart>& parts);

/// \return a Radiance file without run-length encoding. \param lines of the header
/// \param pixels bytes r, g, b, e of each pixel
std::string radiance_file(const std::string& lines, const std::string& resolution,
                          const std::string& pixels);

/// \return a TIFF file of RGB floats. \param orientation value of the tag
std::string tiff_file(int width, int height, const std::vector<float>& rgb, int orientation);

/// A JPEG file of 16 x 8 pixels, black but for the upper left quarter, with an orientation in Exif.
std::string jpeg_file(int orientation);

/// A PFM file of RGB floats from the top left.
std::string pfm_file(int width, int height, const std::vector<float>& rgb);

}  // namespace tyndall::test
