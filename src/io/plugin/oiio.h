/// \file
/// The C interface between tyndall-image (io/helper/protocol.h) and the module tyndall_oiio.so.
#pragma once

#include <cstddef>

extern "C" {

/// An image as its file stores it. Its pixels are RGB floats from the first row and column on;
/// integers of the file are scaled to [0, 1].
struct TyndallImage {
  int width, height;
  int left, top, whole_width, whole_height;  ///< the place of its pixels in the whole image
  int orientation;                           ///< as in TIFF, 1 to 8
  double curve;                              ///< see io/helper/decoded_image.h
};

/// \return memory for 3 width height floats, or null to stop reading.
using TyndallRoom = float*(void* user, const TyndallImage* image);

/// Receives metadata of an image as key and value; a null key marks a warning.
using TyndallTell = void(void* user, const char* key, const char* text);

/// Reads the image of a file that is neither OpenEXR nor Radiance. \return 0 for success, or 1 with
/// the reason in `message` (of `message_size` bytes; empty if room() returned null).
using TyndallReadImage = int(const char* path, TyndallRoom* room, TyndallTell* tell, void* user,
                             char* message, std::size_t message_size);

__attribute__((visibility("default"))) TyndallReadImage tyndall_read_image_2;
}
