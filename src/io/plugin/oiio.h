/// \file
/// What crosses the border between tyndall-image (io/helper/protocol.h) and the module
/// tyndall_oiio.so: plain C.
#pragma once

#include <cstddef>

extern "C" {

/// An image as its file holds it. Its pixels are RGB from the first row and column on, as floats:
/// of 0 to 1 where the file has integers.
struct TyndallImage {
  int width, height;
  int left, top, whole_width, whole_height;  ///< the place of its pixels in the whole
  int orientation;                           ///< TIFF's number
  double curve;                              ///< see io/helper/decoded_image.h
};

/// \return room for 3 width height floats, or null: then nothing more is read.
using TyndallRoom = float*(void* user, const TyndallImage* image);

/// Takes what a file says of its image; without a key it is a warning.
using TyndallTell = void(void* user, const char* key, const char* text);

/// Reads the image of a file that is neither OpenEXR nor Radiance. \return 0, or 1 with a text in
/// `message` (of `message_size` bytes).
using TyndallReadImage = int(const char* path, TyndallRoom* room, TyndallTell* tell, void* user,
                             char* message, std::size_t message_size);

__attribute__((visibility("default"))) TyndallReadImage tyndall_read_image_2;
}
