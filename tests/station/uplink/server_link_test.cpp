#include "station/uplink/server_link.h"

#include <gtest/gtest.h>

#include "tests/station/uplink/fake_server.h"
#include "tests/support/temp_folder.h"

namespace enamel::station {
namespace {

namespace fs = std::filesystem;

class ServerLinkTest : public testing::Test {
 protected:
  test::TempFolder temp_;
  const fs::path folder_ = temp_.path();
};

TEST_F(ServerLinkTest, SigningInTellsThatThePasswordWasForOneUse) {
  for (bool must : {false, true}) {
    FakeServer server(folder_);
    server.must_change_password = must;
    ServerLink link;
    ASSERT_TRUE(link.Connect(server.NewStation()).ok());
    auto person = link.SignIn("ada", "secret");
    ASSERT_TRUE(person.ok()) << person.status().message();
    EXPECT_EQ(person->must_change_password, must);
  }
}

TEST_F(ServerLinkTest, ServerThatOwesAnAnswerAndIsSilentIsLeft) {
  FakeServer server(folder_);
  ServerLink link(std::chrono::milliseconds(50));
  ASSERT_TRUE(link.Connect(server.NewStation()).ok());
  server.silent = true;
  auto person = link.SignIn("ada", "secret");
  EXPECT_EQ(person.status().code(), Code::kUnavailable);
  EXPECT_NE(person.status().message().find("owes an answer"), std::string::npos)
      << person.status().message();
  EXPECT_FALSE(link.connected());
}

TEST_F(ServerLinkTest, ServerThatSaysThatItStillWaitsIsWaitedFor) {
  FakeServer server(folder_);
  server.still_waiting = 3;
  ServerLink link;
  ASSERT_TRUE(link.Connect(server.NewStation()).ok());
  auto person = link.SignIn("ada", "secret");
  ASSERT_TRUE(person.ok()) << person.status().message();
  EXPECT_EQ(person->role, "student");
}

TEST_F(ServerLinkTest, PageIsShownWhereTheServerSaysItAndTheTextIsAnAddress) {
  const std::string fits = "https://" + std::string(192, 'x');
  for (const std::string& url : {std::string("https://enamel.example.edu"),
                                 std::string("http://10.0.0.5:8080/page"), fits}) {
    FakeServer server(folder_);
    server.SetPageUrl(url);
    ServerLink link;
    ASSERT_TRUE(link.Connect(server.NewStation()).ok());
    EXPECT_EQ(link.page_url(), url);
  }
  for (const std::string& other :
       {std::string(), std::string("https://"), std::string("ftp://x"), std::string("http://a b"),
        std::string("https://x\n"), std::string("https://\u00fc.example"), fits + "x"}) {
    FakeServer server(folder_);
    server.SetPageUrl(other);
    ServerLink link;
    ASSERT_TRUE(link.Connect(server.NewStation()).ok());
    EXPECT_EQ(link.page_url(), "") << other;
  }
}

TEST_F(ServerLinkTest, ATicketIsAskedForTheAssignmentThatWasListed) {
  FakeServer server(folder_);
  server.assignments = {Uuid::New(), Uuid{}};
  Credentials credentials = server.NewStation();
  ServerLink link;
  ASSERT_TRUE(link.Connect(credentials).ok());
  auto catalogue = link.ListExercises({});
  ASSERT_TRUE(catalogue.ok()) << catalogue.status().message();
  ASSERT_EQ(catalogue->exercises.size(), 2u);
  for (size_t i = 0; i < 2; ++i) {
    const Catalogue::Exercise& e = catalogue->exercises[i];
    EXPECT_EQ(e.assignment, server.assignments[i]);
    TicketRequest wanted{e.exercise, HashSha256(AsBytes("profile")), e.assignment, i == 1, i == 0};
    EXPECT_EQ(link.RequestTicket(credentials, {}, wanted).status().code(), Code::kForbidden);
    const wire::RequestTicket& asked = server.asked_for();
    EXPECT_EQ(asked.assignment(), i == 0 ? protocol::ToField(e.assignment.view()) : "");
    EXPECT_EQ(asked.profile(), protocol::ToField(wanted.profile.view()));
    EXPECT_EQ(asked.as_reference(), i == 1);
    EXPECT_EQ(asked.for_later(), i == 0);
  }
}

}  // namespace
}  // namespace enamel::station
