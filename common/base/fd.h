#pragma once

#include <unistd.h>

namespace enamel {

// Owns a file descriptor; closes it when it goes. Negative: none, as open(2) answers on failure.
// Thread safety: a value of one owner.
class Fd {
 public:
  explicit Fd(int fd) : fd_(fd) {}
  ~Fd() {
    if (fd_ >= 0) ::close(fd_);
  }
  Fd(const Fd&) = delete;
  Fd& operator=(const Fd&) = delete;
  int get() const { return fd_; }

 private:
  const int fd_;
};

}  // namespace enamel
