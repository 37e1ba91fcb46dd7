/// \file
/// Shows the picture of a running render in the viewer tev.
#pragma once

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "tyndall/render/picture.h"

namespace tyndall::app {

/// Sends pictures to tev (https://github.com/Tom94/tev) or another viewer with its protocol. A
/// separate thread sends them, so a viewer that is slow, hangs or exits does not delay the render.
class Display {
 public:
  /// \param address HOST:PORT, or HOST for tev's own port \throws Error(usage)
  Display(const std::string& address, std::string title);
  /// Waits up to 2 s for the last picture to be sent.
  ~Display();
  Display(const Display&) = delete;
  Display& operator=(const Display&) = delete;

  /// Queues `picture`; it replaces a queued picture that has not been sent yet.
  void show(Picture picture);

 private:
  void run();
  bool connect();
  bool send(const std::string& bytes);

  std::string host_, port_;
  std::string unknown_;  // why the host name could not be resolved
  const std::string title_;
  std::atomic<int> socket_{-1};
  std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<Picture> next_;
  bool is_over_ = false, is_done_ = false;
  std::thread thread_;
};

/// \return the packet of tev's protocol that creates an image of this size.
std::string packet_create_image(const std::string& title, int width, int height);
/// \return the packet of tev's protocol that fills the image with RGBA.
std::string packet_update_image(const std::string& title, const Picture& picture);

}  // namespace tyndall::app
