#pragma once

#include <atomic>

#include "station/devices/button_source.h"
#include "station/hid/hid_reader.h"

namespace enamel::station::hid {

// Where a pedal's reports hold its state. The default is the VEC Infinity, as sold for dictation:
// its descriptor has the buttons 1 to 3 (left, middle, right), so bits 0 to 2 of its first byte,
// and no report ids (its event codes are 0x90001 to 0x90003, HID usage page 9).
struct PedalSettings {
  HidMatch match{0x05f3, 0x00ff, {}, 0, 0};
  uint8_t report_id = 0;  // 0: the device does not number its reports
  uint8_t byte = 0;       // of the report, its id included
  uint8_t mask = 0x07;    // any of these bits: down
};

// "05f3:00ff" (with the defaults above), or "1a86:e026,id=1,byte=3,mask=ff". Errors: kInvalidInput.
Result<PedalSettings> ParsePedal(std::string_view text);

// Whether a report has the pedal down. `relevant` false: the report does not contain it.
struct PedalReading {
  bool relevant = false, down = false;
};
PedalReading ReadPedal(const PedalSettings& settings, ByteView report) noexcept;

// A foot pedal on its own thread. Released while it is unplugged; it works again once it is plugged
// in. Thread safety: buttons and refused from any thread.
class FootPedal final : public ButtonSource, private ReportSink {
 public:
  // Errors: kNotFound, kUnavailable when it may not be opened.
  static Result<std::unique_ptr<FootPedal>> Open(const PedalSettings& settings);

  std::string Name() const override { return name_; }
  ENAMEL_REALTIME uint8_t buttons() const noexcept override {
    return buttons_.load(std::memory_order_relaxed);
  }
  // Reports of another id, or too short.
  uint64_t refused() const noexcept { return refused_.load(std::memory_order_relaxed); }

 private:
  FootPedal(const PedalSettings& settings, std::string name);
  void OnReport(ByteView report) override;
  bool OnAttached(const HidInfo&) override { return true; }
  void OnDetached() override { buttons_ = 0; }

  const PedalSettings settings_;
  const std::string name_;
  std::atomic<uint8_t> buttons_{0};
  std::atomic<uint64_t> refused_{0};
  HidReader reader_;  // last: its thread uses the rest
};

}  // namespace enamel::station::hid
