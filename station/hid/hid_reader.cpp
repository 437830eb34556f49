#include "station/hid/hid_reader.h"

#include <array>
#include <chrono>

#include "station/devices/trouble.h"

namespace enamel::station::hid {
namespace {

// The largest known input report has 48 bytes. The wait between two searches is cut in steps, so
// that ending the reader does not take all of kRetry.
constexpr size_t kMaxReport = 256;
constexpr std::chrono::milliseconds kRetryStep{20};

}  // namespace

Result<HidInfo> FindHid(const HidMatch& match) {
  std::string there;
  for (const HidInfo& info : ListHid()) {
    if (match.Fits(info)) return info;
    there += (there.empty() ? "" : ", ") + HidMatch{info.vendor, info.product, {}, 0, 0}.Text() +
             (info.name.empty() ? "" : " (" + info.name + ")");
  }
  return Status(
      Code::kNotFound,
      (match.vendor == 0 ? "no such device is attached: plug it in. There "
                         : "device " + match.Text() + " is not attached: plug it in. There ") +
          (there.empty() ? "is no HID device at all" : "are " + there) +
          " ('enamel-station devices' lists them)",
      trouble::kNotAttached);
}

HidReader::HidReader(HidMatch match, ReportSink& sink)
    : match_(std::move(match)), sink_(sink), thread_([this] { Run(); }) {}

HidReader::~HidReader() {
  stop_ = true;
  thread_.join();
}

std::unique_ptr<HidPort> HidReader::Find() {
  auto info = FindHid(match_);
  if (!info.ok()) return nullptr;
  auto port = HidPort::Open(info->path);
  if (!port.ok()) return nullptr;
  if (!sink_.OnAttached(*info)) return nullptr;
  return std::move(*port);
}

void HidReader::Run() {
  std::unique_ptr<HidPort> port;
  std::array<uint8_t, kMaxReport> buffer;
  while (!stop_) {
    if (port == nullptr) {
      port = Find();
      for (auto waited = kRetryStep; port == nullptr && waited <= kRetry && !stop_;
           waited += kRetryStep) {
        std::this_thread::sleep_for(kRetryStep);
      }
      continue;
    }
    int got = port->Read(buffer, kPatience_ms);
    if (got > 0) {
      sink_.OnReport({buffer.data(), static_cast<size_t>(got)});
    } else if (got < 0) {
      // Searched again by its ids, since the path may be another's by then.
      sink_.OnDetached();
      port.reset();
    }
  }
}

}  // namespace enamel::station::hid
