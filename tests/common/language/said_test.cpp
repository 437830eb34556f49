// Every text of the programs' sources is in the catalogues, and every text of the catalogues is
// used.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>
#include <string>

#include "common/language/words.h"

namespace enamel::language {
namespace {

namespace fs = std::filesystem;

std::string ReadAll(const fs::path& path) {
  std::ifstream in(path);
  std::stringstream out;
  out << in.rdbuf();
  return out.str();
}

// The sources of all programs that show texts.
const std::string& Sources() {
  static const std::string kAll = [] {
    std::string all;
    for (const char* folder : {"common/language", "station/desk", "station/render", "station/words",
                               "station/app", "station/lab/sheet"}) {
      for (const auto& entry :
           fs::recursive_directory_iterator(fs::path(ENAMEL_SOURCE_DIR) / folder)) {
        if (entry.path().extension() == ".cpp" || entry.path().extension() == ".h") {
          all += ReadAll(entry.path());
        }
      }
    }
    return all;
  }();
  return kAll;
}

std::set<std::string> EnglishKeys() {
  std::set<std::string> out;
  for (const Message& m : MessagesOf(Language::kEnglish)) out.insert(m.key);
  return out;
}

// Wrong ones are said as they are: "sign_in.tilte".
TEST(SaidTest, EveryKeyThatIsSaidIsThere) {
  const std::set<std::string> english = EnglishKeys();
  static const std::regex kSaid(R"re(Say\(\s*"([a-z_0-9.]+)"\s*[,)])re");
  int said = 0;
  for (std::sregex_iterator at(Sources().begin(), Sources().end(), kSaid), end; at != end; ++at) {
    const std::string key = (*at)[1];
    EXPECT_TRUE(english.contains(key)) << "nobody says " << key;
    ++said;
  }
  EXPECT_GT(said, 100);
}

TEST(SaidTest, EveryMessageIsSaidSomewhere) {
  // Made of a name that the tooth, the bur, a reason, a hand or a built-in text has.
  const std::set<std::string> made = {
      "bur",       "builtin_text", "builtin_title", "critical", "critical_error", "device_trouble",
      "direction", "fault_why",    "grade_state",   "group",    "mistake",        "mistake_do",
      "place",     "price_kind",   "reason",        "refusal",  "restoration",    "simulated_hand",
      "tissue"};
  for (const Message& m : MessagesOf(Language::kEnglish)) {
    if (made.contains(m.key.substr(0, m.key.find('.')))) continue;
    EXPECT_NE(Sources().find('"' + m.key + '"'), std::string::npos) << m.key << " is said nowhere";
  }
}

}  // namespace
}  // namespace enamel::language
