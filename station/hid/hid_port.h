#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "common/base/bytes.h"
#include "common/base/result.h"

// HID devices through hidapi; nothing else calls it.
namespace enamel::station::hid {

// A HID interface as the system lists it, without opening it.
struct HidInfo {
  std::string path;  // the system's address, such as /dev/hidraw3
  uint16_t vendor = 0, product = 0;
  uint16_t usage_page = 0, usage = 0;
  int interface_number = -1;
  std::string serial, maker, name;

  bool operator==(const HidInfo&) const = default;
};

// All attached interfaces, by path. Works without the right to open any. Thread safety: any thread.
std::vector<HidInfo> ListHid();

// Criteria of a search; 0 and empty match any.
struct HidMatch {
  uint16_t vendor = 0, product = 0;
  std::string serial;
  uint16_t usage_page = 0, usage = 0;

  bool Fits(const HidInfo& info) const;
  std::string Text() const;  // "05f3:00ff", with the serial number if there is one
};

// "05f3:00ff" or "05f3:00ff:SERIAL". Errors: kInvalidInput with the expected form.
Result<HidMatch> ParseHidMatch(std::string_view text);

// An open interface. Every Open of the same device is a separate handle with its own queue of
// reports: a reading and a writing thread take one each and share nothing. Thread safety: one
// thread at a time. Real-time: never.
class HidPort {
 public:
  // Errors: as OpenNode; kUnavailable.
  static Result<std::unique_ptr<HidPort>> Open(const std::string& path);
  ~HidPort();
  HidPort(const HidPort&) = delete;
  HidPort& operator=(const HidPort&) = delete;

  // Reads one report (its id first, if the device numbers its reports). Returns its size in bytes;
  // 0 if none came in time, negative if the device is detached.
  int Read(std::span<uint8_t> out, int timeout_ms);
  // False if the device is detached or did not accept the report. The id is the first byte.
  bool Write(ByteView report);
  // Errors: kUnavailable.
  Result<Bytes> GetFeature(uint8_t id, size_t size);

 private:
  explicit HidPort(void* handle) : handle_(handle) {}
  void* const handle_;
};

}  // namespace enamel::station::hid
