#include "station/hid/hid_port.h"

#include <hidapi/hidapi.h>

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <filesystem>

#include "common/base/mutex.h"
#include "station/devices/device_node.h"
#include "station/devices/trouble.h"

namespace enamel::station::hid {
namespace {

// hidapi lists and opens through a library context that is not thread-safe.
Mutex context;

std::string Utf8(const wchar_t* text) {
  std::string out;
  if (text == nullptr) return out;
  for (; *text != 0; ++text) {
    auto c = static_cast<uint32_t>(*text);
    if (c < 0x80) {
      out += static_cast<char>(c);
    } else if (c < 0x800) {
      out += static_cast<char>(0xC0 | c >> 6);
      out += static_cast<char>(0x80 | (c & 0x3F));
    } else if (c < 0x10000) {
      out += static_cast<char>(0xE0 | c >> 12);
      out += static_cast<char>(0x80 | (c >> 6 & 0x3F));
      out += static_cast<char>(0x80 | (c & 0x3F));
    } else {
      out += '?';
    }
  }
  return out;
}

hid_device* Handle(void* handle) { return static_cast<hid_device*>(handle); }

bool ParseHex16(std::string_view text, uint16_t& out) {
  auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), out, 16);
  return error == std::errc() && end == text.data() + text.size() && !text.empty();
}

}  // namespace

std::vector<HidInfo> ListHid() {
  MutexLock lock(context);
  std::vector<HidInfo> out;
  hid_device_info* all = hid_enumerate(0, 0);
  for (hid_device_info* d = all; d != nullptr; d = d->next) {
    out.push_back({d->path == nullptr ? "" : d->path, d->vendor_id, d->product_id, d->usage_page,
                   d->usage, d->interface_number, Utf8(d->serial_number),
                   Utf8(d->manufacturer_string), Utf8(d->product_string)});
  }
  hid_free_enumeration(all);
  // By path, so that "the first that matches" is the same one each time.
  std::sort(out.begin(), out.end(),
            [](const HidInfo& a, const HidInfo& b) { return a.path < b.path; });
  return out;
}

bool HidMatch::Fits(const HidInfo& info) const {
  return (vendor == 0 || vendor == info.vendor) && (product == 0 || product == info.product) &&
         (serial.empty() || serial == info.serial) &&
         (usage_page == 0 || (usage_page == info.usage_page && usage == info.usage));
}

std::string HidMatch::Text() const {
  if (vendor == 0) return "any";
  char ids[16];
  std::snprintf(ids, sizeof ids, "%04x:%04x", vendor, product);
  return serial.empty() ? ids : std::string(ids) + ":" + serial;
}

Result<HidMatch> ParseHidMatch(std::string_view text) {
  HidMatch match;
  size_t first = text.find(':');
  std::string_view rest = first == text.npos ? "" : text.substr(first + 1);
  size_t second = rest.find(':');
  if (!ParseHex16(text.substr(0, first), match.vendor) ||
      !ParseHex16(rest.substr(0, second), match.product)) {
    return Status(Code::kInvalidInput,
                  "expected VENDOR:PRODUCT in hexadecimal, as 05f3:00ff, and :SERIAL where two are "
                  "alike; found '" +
                      std::string(text) + "'. 'enamel-station devices' lists what is attached",
                  "device");
  }
  if (second != rest.npos) match.serial = std::string(rest.substr(second + 1));
  return match;
}

Result<std::unique_ptr<HidPort>> HidPort::Open(const std::string& path) {
  // hidapi 0.13 crashes on a node that is there and is no hidraw: it frees what it never set.
  std::error_code missing;
  const auto node = std::filesystem::canonical(path, missing);
  if (!missing && std::filesystem::is_character_file(node) &&
      !std::filesystem::exists("/sys/class/hidraw" / node.filename())) {
    return Status(Code::kUnavailable, path + " is no HID device: plug it in again",
                  trouble::kDevice);
  }
  MutexLock lock(context);
  hid_device* handle = hid_open_path(path.c_str());
  if (handle == nullptr) {
    const std::string why = Utf8(hid_error(nullptr));
    // hidapi does not say which error it was.
    ENAMEL_RETURN_IF_ERROR(WhyNotOpenable(path));
    return Status(Code::kUnavailable, "cannot open " + path + " (" + why + "): plug it in again",
                  trouble::kDevice);
  }
  return std::unique_ptr<HidPort>(new HidPort(handle));
}

HidPort::~HidPort() { hid_close(Handle(handle_)); }

int HidPort::Read(std::span<uint8_t> out, int timeout_ms) {
  return hid_read_timeout(Handle(handle_), out.data(), out.size(), timeout_ms);
}

bool HidPort::Write(ByteView report) {
  return hid_write(Handle(handle_), report.data(), report.size()) >= 0;
}

Result<Bytes> HidPort::GetFeature(uint8_t id, size_t size) {
  Bytes out(size);
  // hidapi needs the id at the answer's place.
  out[0] = id;
  int got = hid_get_feature_report(Handle(handle_), out.data(), out.size());
  if (got < 0) {
    return Status(Code::kUnavailable,
                  "the device does not answer what it is (feature report " + std::to_string(id) +
                      "): plug it in again; if that does not help, its firmware does not follow "
                      "schemas/hid_haptic_report.md",
                  trouble::kSilent);
  }
  out.resize(static_cast<size_t>(got));
  return out;
}

}  // namespace enamel::station::hid
