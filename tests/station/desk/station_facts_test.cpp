#include "station/desk/station_facts.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <algorithm>

#include "tests/station/uplink/fake_server.h"

namespace enamel::station::desk {
namespace {

namespace fs = std::filesystem;

bool Says(const std::vector<std::string>& lines, const std::string& words) {
  return std::ranges::any_of(lines, [&](const std::string& l) { return l.find(words) != l.npos; });
}

TEST(StationFactsLines, NameWhatSomebodyHasToDo) {
  StationFacts facts;
  facts.waiting = 1;
  facts.free_bytes = 41'240'000'000;
  auto lines = Lines(facts);
  EXPECT_TRUE(Says(lines, "the server is reachable"));
  EXPECT_TRUE(Says(lines, "1 recording waits for the server"));
  EXPECT_TRUE(Says(lines, "41.2 GB free"));
  EXPECT_FALSE(Says(lines, "REFUSED"));
  EXPECT_FALSE(Says(lines, "TOO LITTLE"));
  facts.link = {false, true, Status(Code::kUnauthenticated, "another certificate"), 0, 0};
  facts.refused = 2;
  facts.free_bytes = 3'000'000;
  lines = Lines(facts);
  EXPECT_TRUE(Says(lines, "AWAY"));
  EXPECT_TRUE(Says(lines, "another certificate"));
  EXPECT_TRUE(Says(lines, "2 recordings REFUSED"));
  EXPECT_TRUE(Says(lines, "3 MB free: TOO LITTLE"));
}

// Waiting recordings are known before anybody signs in, and without the server.
TEST(StationFactsOf, AStationWithoutItsServerTellWhatWaits) {
  std::string name = (fs::temp_directory_path() / "enamel_facts_XXXXXX").string();
  const fs::path folder = ::mkdtemp(name.data());
  std::optional<FakeServer> server(folder);
  ASSERT_TRUE(SaveCredentials(folder / "data", server->NewStation()).ok());
  server.reset();
  {
    WorkplaceOptions options;
    options.data = folder / "data";
    auto workplace = std::move(*Workplace::Open(options));
    trace::Header header = HeaderOf(Uuid::New());
    ASSERT_TRUE(workplace->spool().BeginAttempt(header, "class-1", "pointer").ok());
    trace::Seal seal;
    seal.attempt = header.ticket.attempt;
    ASSERT_TRUE(workplace->spool().PutSeal(seal).ok());
    while (workplace->uploader().link().reachable) std::this_thread::yield();
    StationFacts facts = LookAtStation(*workplace);
    EXPECT_FALSE(facts.link.reachable);
    EXPECT_FALSE(facts.link.problem.ok());
    EXPECT_EQ(facts.waiting, 1u);
    EXPECT_EQ(facts.refused, 0u);
    ASSERT_TRUE(facts.free_bytes.has_value());
    EXPECT_GT(*facts.free_bytes, 0u);
    EXPECT_TRUE(facts.problem.ok()) << facts.problem.message();
  }
  fs::remove_all(folder);
}

}  // namespace
}  // namespace enamel::station::desk
