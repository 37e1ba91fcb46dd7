/// \file
/// A picture that is watched while it is made: in the viewer tev, or in a file.
#pragma once

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "tyndall/render/picture.h"

namespace tyndall::app {

/// Sends pictures to tev (https://github.com/Tom94/tev), or to what speaks its protocol. From a
/// thread of its own: a viewer that is slow, deaf or gone costs the render nothing.
class Display {
 public:
  /// \param address HOST:PORT, or HOST for tev's own port \throws Error(usage)
  Display(const std::string& address, std::string title);
  /// Waits a moment for the last picture to be sent.
  ~Display();
  Display(const Display&) = delete;
  Display& operator=(const Display&) = delete;

  /// Shows this instead of what has not been sent yet.
  void show(Picture picture);

 private:
  void run();
  bool connect();
  bool send(const std::string& bytes);

  std::string host_, port_;
  std::string unknown_;  // why nobody knows the host
  const std::string title_;
  std::atomic<int> socket_{-1};
  std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<Picture> next_;
  bool is_over_ = false, is_done_ = false;
  std::thread thread_;
};

/// \return the packets of tev's protocol that make an image of that size, and that fill it with
/// RGBA.
std::string packet_create_image(const std::string& title, int width, int height);
std::string packet_update_image(const std::string& title, const Picture& picture);

}  // namespace tyndall::app
