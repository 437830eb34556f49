#include "station/session/hand_turn.h"

#include <spdlog/spdlog.h>

#include <boost/json.hpp>
#include <map>
#include <string>

#include "common/base/file.h"

namespace enamel::station {
namespace {

namespace fs = std::filesystem;
namespace json = boost::json;

// A station has a handful of devices; another file of that name is not read whole.
constexpr size_t kMaxBytes = 1 << 16;

fs::path FileIn(const fs::path& data) { return data / "hand_turns.json"; }

std::string KeyOf(const Device& device) {
  const std::string unit = device.Unit();
  return unit.empty() ? device.Name() : unit;
}

std::map<std::string, int> Read(const fs::path& data) {
  std::map<std::string, int> out;
  const fs::path file = FileIn(data);
  std::error_code error;
  if (!fs::exists(file, error)) return out;
  const auto bytes = ReadFile(file, kMaxBytes);
  const json::value read = bytes.ok() ? json::parse(AsText(*bytes), error) : json::value();
  if (!read.is_object()) {
    spdlog::warn("{}: no object of degrees by device, so devices count as not turned: {}",
                 file.string(), bytes.ok() ? error.message() : bytes.status().message());
    return out;
  }
  for (const auto& [key, value] : read.get_object()) {
    const int64_t* turn_deg = value.if_int64();
    if (turn_deg == nullptr || *turn_deg % 90 != 0 || *turn_deg < 0 || *turn_deg >= 360) {
      spdlog::warn("{}: {}: expected 0, 90, 180 or 270", file.string(), std::string(key));
      continue;
    }
    out[key] = static_cast<int>(*turn_deg);
  }
  return out;
}

}  // namespace

int HandTurnOf(const fs::path& data, const Device& device, int otherwise) {
  const auto all = Read(data);
  const auto found = all.find(KeyOf(device));
  return found == all.end() ? otherwise : found->second;
}

Status KeepHandTurn(const fs::path& data, const Device& device, int turn_deg) {
  auto all = Read(data);
  all[KeyOf(device)] = turn_deg;
  json::object out;
  for (const auto& [key, value] : all) out[key] = value;
  return WriteFileDurably(FileIn(data), AsBytes(json::serialize(out) + "\n"));
}

}  // namespace enamel::station
