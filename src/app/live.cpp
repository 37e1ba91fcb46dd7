#include "app/live.h"

#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <utility>

#include <fmt/format.h>

#include "session/console.h"
#include "tyndall/render/error.h"

namespace tyndall::app {
namespace {

constexpr const char* usual_port = "14158";  // tev's
constexpr int patience = 2000;               // [ms] for one step of a connection

/// A message of tev's protocol: length, then fields; little endian, strings end with 0.
class Packet {
 public:
  explicit Packet(std::uint8_t type) : bytes_(sizeof(std::uint32_t), '\0') { add(type); }
  template <class T>
  Packet& add(T value) {
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
    return *this;
  }
  Packet& add(const std::string& text) {
    bytes_ += text;
    bytes_ += '\0';
    return *this;
  }
  Packet& add(const void* data, std::size_t size) {
    bytes_.append(static_cast<const char*>(data), size);
    return *this;
  }
  std::string bytes() && {
    const auto size = static_cast<std::uint32_t>(bytes_.size());
    std::memcpy(bytes_.data(), &size, sizeof size);
    return std::move(bytes_);
  }

 private:
  std::string bytes_;
};

constexpr std::uint8_t create_image = 4, update_image_v3 = 6;
constexpr std::int32_t channels = 4;
const char* const channel_names[] = {"R", "G", "B", "A"};

}  // namespace

std::string packet_create_image(const std::string& title, int width, int height) {
  Packet packet(create_image);
  packet.add(std::uint8_t{1}).add(title);  // 1: select the image
  packet.add(std::int32_t{width}).add(std::int32_t{height}).add(channels);
  for (const char* name : channel_names) packet.add(std::string(name));
  return std::move(packet).bytes();
}

std::string packet_update_image(const std::string& title, const Picture& picture) {
  Packet packet(update_image_v3);
  packet.add(std::uint8_t{0}).add(title).add(channels);
  for (const char* name : channel_names) packet.add(std::string(name));
  packet.add(std::int32_t{0}).add(std::int32_t{0});
  packet.add(std::int32_t{picture.width}).add(std::int32_t{picture.height});
  for (std::int64_t c = 0; c < channels; ++c) packet.add(c);                       // offsets
  for (std::int64_t c = 0; c < channels; ++c) packet.add(std::int64_t{channels});  // strides
  packet.add(picture.rgba.data(), picture.rgba.size() * sizeof(float));
  return std::move(packet).bytes();
}

Display::Display(const std::string& address, std::string title) : title_(std::move(title)) {
  const std::size_t colon = address.rfind(':');
  host_ = address.substr(0, colon);
  if (host_.size() > 2 && host_.front() == '[' && host_.back() == ']')  // IPv6
    host_ = host_.substr(1, host_.size() - 2);
  port_ = colon == std::string::npos ? usual_port : address.substr(colon + 1);
  int number = 0;
  const char* end = port_.data() + port_.size();
  const auto [stop, error] = std::from_chars(port_.data(), end, number);
  if (host_.empty() || error != std::errc() || stop != end || number < 1 || number > 65535) {
    throw Error(
        ExitCode::usage,
        fmt::format("--display: expected HOST:PORT, such as localhost:14158, got '{}'", address));
  }
  thread_ = std::thread([this] { run(); });
}

Display::~Display() {
  {
    std::unique_lock lock(mutex_);
    is_over_ = true;
    changed_.notify_all();
    changed_.wait_for(lock, std::chrono::milliseconds(patience), [this] { return is_done_; });
  }
  if (socket_ >= 0) ::shutdown(socket_, SHUT_RDWR);  // interrupts send()
  thread_.join();
  if (socket_ >= 0) ::close(socket_);
}

void Display::show(Picture picture) {
  const std::lock_guard lock(mutex_);
  next_ = std::move(picture);
  changed_.notify_all();
}

void Display::run() {
  bool is_there = true;
  int width = 0, height = 0;
  for (;;) {
    Picture picture;
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [this] { return next_ || is_over_; });
      if (!next_ || !is_there) {
        next_.reset();
        if (!is_over_) continue;
        is_done_ = true;
        changed_.notify_all();
        return;
      }
      picture = std::move(*next_);
      next_.reset();
    }
    is_there = socket_ >= 0 || connect();
    if (is_there && (picture.width != width || picture.height != height)) {
      width = picture.width, height = picture.height;
      is_there = send(packet_create_image(title_, width, height));
    }
    is_there = is_there && send(packet_update_image(title_, picture));
    if (!is_there)
      session::warn(fmt::format("--display {}:{}: {}; the render goes on without it", host_, port_,
                                unknown_.empty() ? std::strerror(errno) : unknown_));
  }
}

bool Display::connect() {
  addrinfo wanted{}, *found = nullptr;
  wanted.ai_family = AF_UNSPEC;
  wanted.ai_socktype = SOCK_STREAM;
  if (const int problem = ::getaddrinfo(host_.c_str(), port_.c_str(), &wanted, &found)) {
    unknown_ = ::gai_strerror(problem);
    return false;
  }
  int error = EHOSTUNREACH;
  for (const addrinfo* a = found; a && socket_ < 0; a = a->ai_next) {
    const int s =
        ::socket(a->ai_family, a->ai_socktype | SOCK_CLOEXEC | SOCK_NONBLOCK, a->ai_protocol);
    if (s < 0) continue;
    error = ::connect(s, a->ai_addr, a->ai_addrlen) == 0 ? 0 : errno;
    if (error == EINPROGRESS) {
      pollfd ready{s, POLLOUT, 0};
      socklen_t size = sizeof error;
      if (::poll(&ready, 1, patience) != 1)
        error = ETIMEDOUT;
      else
        ::getsockopt(s, SOL_SOCKET, SO_ERROR, &error, &size);
    }
    if (error == 0)
      socket_ = s;
    else
      ::close(s);
  }
  ::freeaddrinfo(found);
  errno = error;
  return socket_ >= 0;
}

bool Display::send(const std::string& bytes) {
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t n = ::send(socket_, bytes.data() + done, bytes.size() - done, MSG_NOSIGNAL);
    if (n > 0) {
      done += static_cast<std::size_t>(n);
      continue;
    }
    if (n < 0 && errno == EINTR) continue;
    if (n < 0 && errno != EAGAIN) return false;
    pollfd ready{socket_, POLLOUT, 0};
    if (::poll(&ready, 1, patience) == 0) {
      errno = ETIMEDOUT;
      return false;
    }
  }
  return true;
}

}  // namespace tyndall::app
