#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "station/hid/hid_port.h"

namespace enamel::station::hid {

// What a reader's thread hands on; called on that thread only, never two at once.
class ReportSink {
 public:
  virtual ~ReportSink() = default;
  virtual void OnReport(ByteView report) = 0;
  // Opened, also again after it was unplugged. False: this is not the one that is meant, or it does
  // not answer yet; it is closed, no report of it is handed on, and it is tried again after kRetry.
  virtual bool OnAttached(const HidInfo& info) = 0;
  // The one that OnAttached took is gone.
  virtual void OnDetached() = 0;
};

// Reads one HID device on a thread of its own, for as long as it lives: waits for reports, notices
// when it is unplugged, and looks for it again every kRetry until it is back (hot-plug).
// Thread safety: constructed and destroyed by one thread. Destruction takes at most kPatience.
class HidReader {
 public:
  static constexpr std::chrono::milliseconds kRetry{200};
  static constexpr int kPatience_ms = 50;

  // `sink` outlives the reader. `match` also finds it again; the path may then be another.
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

// The first attached interface that fits. Errors: kNotFound with what is attached.
Result<HidInfo> FindHid(const HidMatch& match);

}  // namespace enamel::station::hid
