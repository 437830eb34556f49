#include "station/uplink/policy_file.h"

#include <spdlog/spdlog.h>

#include "common/base/file.h"

namespace enamel::station {
namespace {

std::filesystem::path PolicyFile(const std::filesystem::path& data) { return data / "policy.json"; }

}  // namespace

protocol::Policy LoadPolicy(const std::filesystem::path& data) {
  const std::filesystem::path file = PolicyFile(data);
  std::error_code error;
  if (!std::filesystem::exists(file, error)) return {};
  auto bytes = ReadFile(file, protocol::kMaxPolicyBytes);
  auto policy = bytes.ok() ? protocol::PolicyFromJson(AsText(*bytes))
                           : Result<protocol::Policy>(bytes.status());
  if (policy.ok()) return std::move(*policy);
  spdlog::warn("{}: counts as no policy: {}", file.string(), policy.status().message());
  return {};
}

void KeepPolicy(const std::filesystem::path& data, const protocol::Policy& policy) {
  const std::string json = protocol::PolicyJson(policy);
  if (json == protocol::PolicyJson(LoadPolicy(data))) return;
  if (Status kept = WriteFileDurably(PolicyFile(data), AsBytes(json)); !kept.ok()) {
    return spdlog::warn("the server's policy could not be kept: {}", kept.message());
  }
  spdlog::info("the server gave {} settings, which programs that start from now on take",
               policy.settings_size());
}

}  // namespace enamel::station
