#include "server/auth/common_passwords.h"

#include <algorithm>
#include <unordered_map>

namespace enamel::server::auth {

const std::vector<std::string_view>& CommonPasswords() {
  static const std::vector<std::string_view> kAll = [] {
    std::vector<std::string_view> out;
    for (std::string_view rest = CommonPasswordsFile(); !rest.empty();) {
      const std::string_view line = rest.substr(0, rest.find('\n'));
      rest.remove_prefix(std::min(rest.size(), line.size() + 1));
      if (!line.empty() && !line.starts_with("# ")) out.push_back(line);
    }
    return out;
  }();
  return kAll;
}

int CommonRank(std::string_view lower) {
  static const std::unordered_map<std::string_view, int> kRanks = [] {
    std::unordered_map<std::string_view, int> out;
    for (std::string_view one : CommonPasswords()) out.emplace(one, int(out.size()) + 1);
    return out;
  }();
  auto found = kRanks.find(lower);
  return found == kRanks.end() ? 0 : found->second;
}

}  // namespace enamel::server::auth
