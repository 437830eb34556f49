#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "station/hid/hid_port.h"

namespace enamel::station::hid {

// Receives what a reader reads; called on the reader's thread only, never two at once.
class ReportSink {
 public:
  virtual ~ReportSink() = default;
  virtual void OnReport(ByteView report) = 0;
  // A device was opened, at first or after it was unplugged. Return false if it is the wrong one or
  // does not answer yet: it is closed, its reports are dropped, and it is tried again after kRetry.
  virtual bool OnAttached(const HidInfo& info) = 0;
  // The device that OnAttached accepted was detached.
  virtual void OnDetached() = 0;
};

// Reads one HID device on its own thread: waits for reports, notices when the device is unplugged,
// and searches for it every kRetry until it returns (hot-plug). Thread safety: constructed and
// destroyed by one thread. The destructor takes at most kPatience.
class HidReader {
 public:
  static constexpr std::chrono::milliseconds kRetry{200};
  static constexpr int kPatience_ms = 50;

  // `sink` outlives the reader. `match` also finds the device again, which may then have another
  // path.
  HidReader(HidMatch match, ReportSink& sink);
  ~HidReader();
  HidReader(const HidReader&) = delete;
  HidReader& operator=(const HidReader&) = delete;

 private:
  void Run();
  std::unique_ptr<HidPort> Find();

  const HidMatch match_;
  ReportSink& sink_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

// The first attached interface that matches. Errors: kNotFound with what is attached.
Result<HidInfo> FindHid(const HidMatch& match);

}  // namespace enamel::station::hid
