#include "common/protocol/release.h"

#include <array>
#include <charconv>
#include <cstdlib>
#include <optional>
#include <string>

namespace enamel::protocol {
namespace {

struct Release {
  int major = 0;
  int minor = 0;
};

// "0.9.0".
std::optional<Release> ReadRelease(std::string_view text) {
  std::array<int, 3> parts{};
  const char* at = text.data();
  const char* const end = at + text.size();
  for (size_t i = 0; i < parts.size(); ++i) {
    if (i > 0 && (at == end || *at++ != '.')) return std::nullopt;
    const auto [stop, error] = std::from_chars(at, end, parts[i]);
    if (error != std::errc() || parts[i] < 0) return std::nullopt;
    at = stop;
  }
  if (at != end) return std::nullopt;
  return Release{parts[0], parts[1]};
}

bool IsOlder(const Release& one, const Release& other) {
  return one.major != other.major ? one.major < other.major : one.minor < other.minor;
}

}  // namespace

std::string_view ThisRelease() { return ENAMEL_VERSION; }

Status MayMeet(std::string_view server, std::string_view station) {
  if (station.empty()) return Status::Ok();
  const auto mine = ReadRelease(server);
  const auto theirs = ReadRelease(station);
  if (!mine || !theirs) {
    return Status(Code::kInvalidInput, "expected a release such as \"0.9.0\"", "release");
  }
  const bool near = mine->major == theirs->major && std::abs(mine->minor - theirs->minor) <= 1;
  if (near) return Status::Ok();
  const std::string mine_is(server), found(station);
  return Status(
      Code::kVersion,
      "this server is Enamel " + mine_is + ", the station " + found +
          "; they may be one minor version apart: " +
          (IsOlder(*theirs, *mine)
               ? "install Enamel " + mine_is +
                     " at the station, which keeps its recordings and sends them then"
               : "install Enamel " + mine_is + " at the station, or update the server first"),
      "release");
}

}  // namespace enamel::protocol
