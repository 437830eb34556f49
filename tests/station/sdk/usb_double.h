#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <string>

#include "common/base/bytes.h"

// libusb without a bus: linked in place of libusb, with devices that a test plugs in and scripts. It has every
// function that the station calls, with libusb's signature and return values.
namespace enamel::station::testing_support {

struct ScriptedUsb {
  uint16_t vendor = 0, product = 0;
  bool may_open = true;   // false: permission denied
  bool confined = false;  // true: operation not permitted
  Bytes endless = {};     // a packet that is there whenever none of Send's is; empty: none
  // Both are called while the bus is locked.
  // True: the chip drops what it has not passed on.
  std::function<bool(uint8_t request, uint16_t value)> control = {};
  std::function<void(ByteView)> written = {};
};

// One per process, as libusb is. Thread safety: all of it.
class UsbBus {
 public:
  static UsbBus& Get();

  // `place` as libusb has it: "1-2", a bus and a port.
  void Plug(const std::string& place, ScriptedUsb device);
  // Requests and transfers fail from now on; waiting ones return at once.
  void Unplug(const std::string& place);
  // A packet to whoever has claimed the device. What is not read is kept, as many as a chip keeps bytes.
  void Send(const std::string& place, Bytes packet);
  // Packets that nobody has read.
  size_t Waiting(const std::string& place);

  struct Socket {
    ScriptedUsb device;
    bool claimed = false;
    std::deque<Bytes> packets;
  };
  // --- libusb's side, with `mutex` held ---
  Socket* At(const std::string& place);
  std::map<std::string, Socket>& sockets() { return sockets_; }
  std::mutex mutex;
  std::condition_variable changed;

 private:
  std::map<std::string, Socket> sockets_;
};

}  // namespace enamel::station::testing_support
