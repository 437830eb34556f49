#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <thread>

#include "common/base/check.h"

namespace enamel::station::desk {

// Runs one task off the window's thread, because it may wait for the server or the disk. The work
// runs on its own thread and returns a function for its outcome; Poll calls that. One task at a
// time. Thread safety: owner's thread.
class BackgroundTask {
 public:
  using After = std::function<void()>;

  ~BackgroundTask() { Join(); }

  // Requires: !busy(). `what` is shown to the person waiting, a key of the words: "task.sign_in".
  void Start(std::string what, std::function<After()> work) {
    ENAMEL_CHECK(!busy());
    what_ = std::move(what);
    done_ = forgotten_ = false;
    running_ = true;
    thread_ = std::thread([this, work = std::move(work)] {
      after_ = work();
      done_.store(true, std::memory_order_release);
    });
  }
  bool busy() const { return running_; }
  const std::string& what() const { return what_; }
  // Discards the outcome. The task still has to end before another can start.
  void Forget() { forgotten_ = true; }
  // Once a frame.
  void Poll() {
    if (!running_ || !done_.load(std::memory_order_acquire)) return;
    Join();
    After after = std::move(after_);
    if (!forgotten_ && after) after();
  }

 private:
  void Join() {
    if (thread_.joinable()) thread_.join();
    running_ = false;
  }

  std::string what_;
  std::thread thread_;
  After after_;
  std::atomic<bool> done_{false};
  bool running_ = false, forgotten_ = false;
};

}  // namespace enamel::station::desk
