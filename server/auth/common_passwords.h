#pragma once

#include <string_view>
#include <vector>

// Some 49 000 passwords that leaked most often (common_passwords.txt, which says where it is from;
// it travels inside the program). Thread safety: functions, any thread.
namespace enamel::server::auth {

// The file, unchanged.
std::string_view CommonPasswordsFile();
// In lower case, the commonest first.
const std::vector<std::string_view>& CommonPasswords();
// 1 for the commonest, 0 for a word that is not on the list. `lower` is in lower case.
int CommonRank(std::string_view lower);

}  // namespace enamel::server::auth
