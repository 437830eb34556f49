#include "station/session/last_device.h"

#include <spdlog/spdlog.h>

#include <boost/json.hpp>

#include "common/base/file.h"

namespace enamel::station {
namespace {

namespace fs = std::filesystem;
namespace json = boost::json;

constexpr char kDeviceMark[] = "enamel_last_device";
constexpr int kDeviceFormat = 1;
// Titles come from devices; a longer file is not read.
constexpr size_t kMaxDeviceBytes = 1 << 12;

fs::path DeviceFile(const fs::path& data) { return data / "last_device.json"; }

std::optional<LastDevice> DeviceFromJson(const json::value& read) {
  if (!read.is_object()) return std::nullopt;
  const json::object& file = read.get_object();
  const json::value *format = file.if_contains(kDeviceMark), *title = file.if_contains("title"),
                    *profile = file.if_contains("profile");
  if (format == nullptr || *format != kDeviceFormat) return std::nullopt;
  if (title == nullptr || !title->is_string() || title->get_string().empty()) return std::nullopt;
  if (profile == nullptr || !profile->is_string()) return std::nullopt;
  if (profile->get_string().empty()) return std::nullopt;
  return LastDevice{std::string(title->get_string()), std::string(profile->get_string())};
}

}  // namespace

std::optional<LastDevice> LastDeviceOf(const fs::path& data) {
  const fs::path file = DeviceFile(data);
  std::error_code error;
  if (!fs::exists(file, error)) return std::nullopt;
  const auto bytes = ReadFile(file, kMaxDeviceBytes);
  const json::value read = bytes.ok() ? json::parse(AsText(*bytes), error) : json::value();
  auto device = DeviceFromJson(read);
  if (!device) {
    spdlog::warn("{}: counts as no device, until one is cut with: {}", file.string(),
                 !bytes.ok() ? bytes.status().message()
                 : error     ? error.message()
                             : "expected members 'enamel_last_device' (1), 'title' and 'profile'");
  }
  return device;
}

Status KeepLastDevice(const fs::path& data, const LastDevice& device) {
  const json::object out{
      {kDeviceMark, kDeviceFormat}, {"title", device.title}, {"profile", device.profile}};
  return WriteFileDurably(DeviceFile(data), AsBytes(json::serialize(out) + "\n"));
}

}  // namespace enamel::station
