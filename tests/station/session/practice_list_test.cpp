#include "station/session/practice_list.h"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "common/base/file.h"
#include "tests/support/temp_folder.h"

namespace enamel::station {
namespace {

constexpr int64_t kNow_ms = 1'800'000'000'000;

class PracticeListTest : public testing::Test {
 protected:
  static Sha256 Hash(const std::string& of) { return HashSha256(AsBytes(of)); }
  static Catalogue::Exercise Listed(const std::string& name, const std::string& version = "1") {
    Catalogue::Exercise out;
    out.name = name;
    out.exercise = Hash(name + version);
    out.facts = Catalogue::Facts();
    out.facts->graded = false;
    return out;
  }
  static Catalogue List(std::vector<Catalogue::Exercise> exercises) {
    Catalogue out;
    out.exercises = std::move(exercises);
    return out;
  }
  std::vector<std::string> Names() const {
    std::vector<std::string> out;
    for (const auto& [name, hash] : LoadPracticeList(temp_.path()).exercises) out.push_back(name);
    return out;
  }
  void Keep(const Catalogue& list) { KeepPracticeList(temp_.path(), list, kNow_ms); }
  std::filesystem::path file() const { return temp_.path() / "practice.json"; }
  void Write(const std::string& text) { std::ofstream(file(), std::ios::binary) << text; }

  test::TempFolder temp_;
};

TEST_F(PracticeListTest, HasWhatAnybodyMayPractise) {
  EXPECT_TRUE(Names().empty());
  auto graded = Listed("graded"), exam = Listed("exam"), exam_too = Listed("practice and exam"),
       later = Listed("later"), unread = Listed("unread");
  graded.facts->graded = true;
  exam.exam = true;
  exam_too.exam = true;
  later.opens_unix_ms = kNow_ms + 1;
  unread.facts.reset();
  Keep(List({graded, exam, Listed("practice and exam"), exam_too, later, unread, Listed(""),
             Listed("class-1")}));
  EXPECT_EQ(Names(), std::vector<std::string>{"class-1"});
}

TEST_F(PracticeListTest, EverybodysListAddsToItAndTheNewestVersionStays) {
  Catalogue first = List({Listed("a"), Listed("b")});
  first.profiles = {{"pointer", "Mouse", Hash("p1")}};
  Keep(first);
  auto now_graded = Listed("b");
  now_graded.facts->graded = true;
  Keep(List({Listed("c"), Listed("a", "2"), now_graded}));
  EXPECT_EQ(Names(), (std::vector<std::string>{"c", "a"}));
  const PracticeList list = LoadPracticeList(temp_.path());
  EXPECT_EQ(list.exercises[1].second, Hash("a2"));
  ASSERT_EQ(list.profiles.size(), 1U);
  EXPECT_EQ(list.profiles[0], std::pair("pointer" + std::string(), Hash("p1")));
}

TEST_F(PracticeListTest, ADamagedFileCountsAsNoneAndIsReplaced) {
  Keep(List({Listed("a")}));
  std::stringstream whole;
  whole << std::ifstream(file()).rdbuf();
  const std::string good = whole.str();
  // Without its last line break it is whole.
  for (size_t size = 0; size + 1 < good.size(); ++size) {
    Write(good.substr(0, size));
    ASSERT_TRUE(Names().empty()) << size;
  }
  const std::string hash = Hash("a").Hex();
  const std::string head = R"({"enamel_practice":1,"profiles":{},"exercises":)";
  for (const std::string& bad :
       {head + "[]}", head + R"({"a":1}})", head + R"({"a":"12"}})",
        head + R"({"a":")" + hash.substr(1) + R"(g"}})", head + "null}", std::string("[]"),
        R"({"enamel_practice":2,"profiles":{},"exercises":{"a":")" + hash + R"("}})",
        head + R"({")" + std::string(201, 'n') + R"(":")" + hash + R"("}})",
        std::string(2 << 20, ' ') + good, std::string(100'000, '[')}) {
    Write(bad);
    EXPECT_TRUE(Names().empty()) << bad.substr(0, 200);
  }
  Write(head + R"({"a":")" + hash + R"("}})");
  EXPECT_EQ(Names(), std::vector<std::string>{"a"}) << "the frame of the bad ones is good";
  Write("damaged");
  Keep(List({Listed("b")}));
  EXPECT_EQ(Names(), std::vector<std::string>{"b"});
}

TEST_F(PracticeListTest, KeepsNoMoreThanItReads) {
  std::vector<Catalogue::Exercise> many(2000, Listed("x"));
  for (size_t i = 0; i < many.size(); ++i) {
    many[i].name = std::to_string(i) + std::string(190, '\x01');  // six bytes each in JSON
  }
  Keep(List(std::move(many)));
  EXPECT_EQ(Names().size(), 500U);
}

}  // namespace
}  // namespace enamel::station
