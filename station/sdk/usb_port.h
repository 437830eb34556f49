#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "common/base/bytes.h"
#include "common/base/result.h"

// USB devices without a driver of the system's, through libusb; nothing else calls it.
namespace enamel::station::sdk {

struct UsbInfo {
  uint16_t vendor = 0, product = 0;
  std::string place;  // the socket, "1-2.3", as UsbPlace says it
  std::string node;   // its device file
};

// Attached devices with these ids, by place. Opens none. Thread safety: any thread.
std::vector<UsbInfo> ListUsb(uint16_t vendor, uint16_t product);

// Interface 0 of a device, for this program alone. Thread safety: one thread at a time. Real-time: never.
class UsbPort {
 public:
  // A full-speed endpoint's packets are no longer.
  static constexpr size_t kPacketBytes = 64;

  // Takes the interface from the system's own driver until it is closed. `in` and `out` are the
  // endpoints of its bulk transfers. Errors: kUnavailable, with what to do.
  static Result<std::unique_ptr<UsbPort>> Open(const UsbInfo& info, uint8_t in, uint8_t out);
  ~UsbPort();
  UsbPort(const UsbPort&) = delete;
  UsbPort& operator=(const UsbPort&) = delete;

  // A request of the maker's to the device, without data. False: it is detached.
  bool Control(uint8_t request, uint16_t value);
  // What the device does not take within 20 ms is lost, as on a cable. False: it is detached.
  bool Write(ByteView bytes);
  // The next packet, of at most kPacketBytes. Returns its size; 0: none in time, or an empty one; negative:
  // the device is detached.
  int Read(std::span<uint8_t> out, std::chrono::microseconds patience);

 private:
  struct Handles;
  explicit UsbPort(std::unique_ptr<Handles> handles);

  const std::unique_ptr<Handles> handles_;
};

}  // namespace enamel::station::sdk
