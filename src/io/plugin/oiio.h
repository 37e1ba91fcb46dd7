/// \file
/// What crosses the border between the executable and the module tyndall_oiio.so: plain C.
#pragma once

#include <cstddef>

extern "C" {

/// Takes the next `size` bytes of the file; called once, after all went well.
using TyndallSink = void (*)(void* user, const void* bytes, std::size_t size);

/// Encodes `rgb` (3 width height bytes on the sRGB curve, from the top left) as PNG.
/// \return 0, or 1 with a text in `message` (of `message_size` bytes).
using TyndallEncodePng = int(int width, int height, const unsigned char* rgb, TyndallSink sink,
                             void* user, char* message, std::size_t message_size);

/// \return room for 3 width height floats.
using TyndallRoom = float*(void* user, int width, int height);

/// Reads the first image of a file to RGB, from the top left, as floats: of 0 to 1 where the file
/// has integers. `on_curve` is set to 1 where these are on the sRGB curve, and 0 where they are
/// linear. \return 0, or 1 with a text in `message` (of `message_size` bytes).
using TyndallReadImage = int(const char* path, TyndallRoom* room, void* user, int* on_curve,
                             char* message, std::size_t message_size);

__attribute__((visibility("default"))) TyndallEncodePng tyndall_encode_png_1;
__attribute__((visibility("default"))) TyndallReadImage tyndall_read_image_1;
}
