#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "common/base/bytes.h"

// hidapi without a bus: linked in place of libhidapi, with devices that a test plugs in and
// scripts. It has every function that the station calls, with hidapi's signature and return values.
namespace enamel::station::testing_support {

struct ScriptedHid {
  std::string path;
  uint16_t vendor = 0, product = 0, usage_page = 0, usage = 0;
  std::wstring serial, maker, name;
  Bytes feature;         // answer to every feature request; empty: none
  bool may_open = true;  // false: permission denied
  Bytes endless = {};    // a report that is there whenever no other is; empty: none
  // A device that only answers: called for each report written to it, while the bus is locked. Empty: no
  // answer.
  std::function<Bytes(ByteView)> answer = {};
};

// One per process, as hidapi is. Thread safety: all of it.
class HidBus {
 public:
  static HidBus& Get();

  // No devices, nothing scripted. Handles that are still open read as detached.
  void Reset();
  void Plug(const ScriptedHid& device);
  // Reads and writes of its open handles fail from now on; waiting ones return at once.
  void Unplug(const std::string& path);
  // One input report, to every open handle of the device and no other.
  void Send(const std::string& path, ByteView report);
  // Writes wait until they are released (the bus is stalled).
  void HoldWrites(bool held);
  int WritesWaiting();
  std::vector<Bytes> Written();
  int OpenHandles();
  // Number of handles opened since Reset.
  int Opened();
  // Waits until `what` is true of this bus; false after ten seconds.
  template <typename What>
  bool Await(What what) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, std::chrono::seconds(10), [&] { return what(*this); });
  }
  // Unlocked views for Await.
  size_t written_count() const { return written_.size(); }
  const std::vector<Bytes>& written() const { return written_; }
  int waiting() const { return waiting_; }
  int handle_count() const { return static_cast<int>(handles_.size()); }
  int opened() const { return opened_; }

  struct Handle {
    std::string path;
    bool gone = false;
    std::deque<Bytes> reports;
  };
  // --- hidapi's side ---
  std::vector<ScriptedHid> Devices();
  Handle* Open(const std::string& path);
  void Close(Handle* handle);
  int Read(Handle* handle, unsigned char* out, size_t size, int timeout_ms);
  int Write(Handle* handle, const unsigned char* data, size_t size);
  int Feature(Handle* handle, unsigned char* data, size_t size);

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::map<std::string, ScriptedHid> devices_;
  std::vector<Handle*> handles_;
  std::vector<Bytes> written_;
  bool held_ = false;
  int waiting_ = 0, opened_ = 0;
};

}  // namespace enamel::station::testing_support
