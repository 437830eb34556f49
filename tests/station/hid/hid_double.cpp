#include "tests/station/hid/hid_double.h"

#include <hidapi/hidapi.h>

#include <algorithm>
#include <cstring>
#include <cwchar>

namespace enamel::station::testing_support {

HidBus& HidBus::Get() {
  static HidBus bus;
  return bus;
}

void HidBus::Reset() {
  std::lock_guard lock(mutex_);
  devices_.clear();
  written_.clear();
  held_ = false;
  opened_ = 0;
  for (Handle* h : handles_) h->gone = true;
  changed_.notify_all();
}

void HidBus::Plug(const ScriptedHid& device) {
  std::lock_guard lock(mutex_);
  devices_[device.path] = device;
  changed_.notify_all();
}

void HidBus::Unplug(const std::string& path) {
  std::lock_guard lock(mutex_);
  devices_.erase(path);
  for (Handle* h : handles_) h->gone = h->gone || h->path == path;
  changed_.notify_all();
}

void HidBus::Send(const std::string& path, ByteView report) {
  std::lock_guard lock(mutex_);
  for (Handle* h : handles_) {
    if (h->path == path) h->reports.emplace_back(report.begin(), report.end());
  }
  changed_.notify_all();
}

void HidBus::HoldWrites(bool held) {
  std::lock_guard lock(mutex_);
  held_ = held;
  changed_.notify_all();
}

int HidBus::WritesWaiting() {
  std::lock_guard lock(mutex_);
  return waiting_;
}

std::vector<Bytes> HidBus::Written() {
  std::lock_guard lock(mutex_);
  return written_;
}

int HidBus::OpenHandles() {
  std::lock_guard lock(mutex_);
  return static_cast<int>(handles_.size());
}

int HidBus::Opened() {
  std::lock_guard lock(mutex_);
  return opened_;
}

std::vector<ScriptedHid> HidBus::Devices() {
  std::lock_guard lock(mutex_);
  std::vector<ScriptedHid> out;
  for (const auto& [path, device] : devices_) out.push_back(device);
  return out;
}

HidBus::Handle* HidBus::Open(const std::string& path) {
  std::lock_guard lock(mutex_);
  auto it = devices_.find(path);
  if (it == devices_.end() || !it->second.may_open) return nullptr;
  handles_.push_back(new Handle{path, false, {}});
  ++opened_;
  changed_.notify_all();
  return handles_.back();
}

void HidBus::Close(Handle* handle) {
  std::lock_guard lock(mutex_);
  handles_.erase(std::find(handles_.begin(), handles_.end(), handle));
  delete handle;
  changed_.notify_all();
}

int HidBus::Read(Handle* handle, unsigned char* out, size_t size, int timeout_ms) {
  std::unique_lock lock(mutex_);
  if (const auto it = devices_.find(handle->path);
      it != devices_.end() && handle->reports.empty() && !it->second.endless.empty()) {
    handle->reports.push_back(it->second.endless);
  }
  changed_.wait_for(lock, std::chrono::milliseconds(timeout_ms),
                    [&] { return handle->gone || !handle->reports.empty(); });
  if (handle->gone) return -1;
  if (handle->reports.empty()) return 0;
  Bytes report = std::move(handle->reports.front());
  handle->reports.pop_front();
  size_t n = std::min(size, report.size());
  std::copy_n(report.begin(), n, out);  // which may be of 0 bytes
  changed_.notify_all();
  return static_cast<int>(n);
}

int HidBus::Write(Handle* handle, const unsigned char* data, size_t size) {
  std::unique_lock lock(mutex_);
  ++waiting_;
  changed_.notify_all();
  changed_.wait(lock, [&] { return !held_ || handle->gone; });
  --waiting_;
  changed_.notify_all();
  if (handle->gone) return -1;
  written_.emplace_back(data, data + size);
  const auto device = devices_.find(handle->path);
  if (device != devices_.end() && device->second.answer) {
    const Bytes answer = device->second.answer({data, size});
    for (Handle* h : handles_) {
      if (h->path == handle->path && !answer.empty()) h->reports.push_back(answer);
    }
    changed_.notify_all();
  }
  return static_cast<int>(size);
}

int HidBus::Feature(Handle* handle, unsigned char* data, size_t size) {
  std::lock_guard lock(mutex_);
  auto it = devices_.find(handle->path);
  if (handle->gone || it == devices_.end() || it->second.feature.empty()) return -1;
  size_t n = std::min(size, it->second.feature.size());
  std::copy_n(it->second.feature.begin(), n, data);
  return static_cast<int>(n);
}

}  // namespace enamel::station::testing_support

// --- hidapi.h's functions, as far as the station calls them ---

using enamel::station::testing_support::HidBus;

namespace {

HidBus::Handle* Of(hid_device* device) { return reinterpret_cast<HidBus::Handle*>(device); }

wchar_t* Copied(const std::wstring& text) {
  auto* out = new wchar_t[text.size() + 1];
  std::wmemcpy(out, text.c_str(), text.size() + 1);
  return out;
}

}  // namespace

extern "C" {

hid_device_info* hid_enumerate(unsigned short vendor, unsigned short product) {
  hid_device_info* first = nullptr;
  for (const auto& d : HidBus::Get().Devices()) {
    if ((vendor != 0 && vendor != d.vendor) || (product != 0 && product != d.product)) continue;
    auto* info = new hid_device_info{};
    info->path = new char[d.path.size() + 1];
    std::memcpy(info->path, d.path.c_str(), d.path.size() + 1);
    info->vendor_id = d.vendor;
    info->product_id = d.product;
    info->usage_page = d.usage_page;
    info->usage = d.usage;
    info->interface_number = 0;
    info->serial_number = Copied(d.serial);
    info->manufacturer_string = Copied(d.maker);
    info->product_string = Copied(d.name);
    info->next = first;
    first = info;
  }
  return first;
}

void hid_free_enumeration(hid_device_info* devices) {
  while (devices != nullptr) {
    hid_device_info* next = devices->next;
    delete[] devices->path;
    delete[] devices->serial_number;
    delete[] devices->manufacturer_string;
    delete[] devices->product_string;
    delete devices;
    devices = next;
  }
}

hid_device* hid_open_path(const char* path) {
  return reinterpret_cast<hid_device*>(HidBus::Get().Open(path));
}

void hid_close(hid_device* device) { HidBus::Get().Close(Of(device)); }

int hid_read_timeout(hid_device* device, unsigned char* data, size_t size, int timeout_ms) {
  return HidBus::Get().Read(Of(device), data, size, timeout_ms);
}

int hid_write(hid_device* device, const unsigned char* data, size_t size) {
  return HidBus::Get().Write(Of(device), data, size);
}

int hid_get_feature_report(hid_device* device, unsigned char* data, size_t size) {
  return HidBus::Get().Feature(Of(device), data, size);
}

const wchar_t* hid_error(hid_device*) { return L"Permission denied"; }

}  // extern "C"
