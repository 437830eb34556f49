#include "station/session/ticket_safe.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <fstream>
#include <thread>

#include "tests/support/temp_folder.h"

namespace enamel::station {
namespace {

namespace fs = std::filesystem;

constexpr char kPin[] = "804217", kOther[] = "804218";
constexpr int64_t kHour_ms = 3'600'000;

class TicketSafeTest : public testing::Test {
 protected:
  TicketSafeTest() {
    spool_ = std::move(*Spool::Open(folder_));
    ticket_.attempt = Uuid::New();
    ticket_.person = Uuid::New();
    ticket_.expires_unix_ms = now_ms_ + 12 * kHour_ms;
  }
  ~TicketSafeTest() override { spool_.reset(); }

  Status Put() {
    LockedTicket names;
    names.person = "Student One";
    return Safe().Put(ticket_, names, kPin);
  }
  TicketSafe Safe() {
    return TicketSafe(*spool_, [this] { return now_ms_; });
  }
  trace::Header Header() const {
    trace::Header header;
    header.ticket = ticket_;
    header.hand.kind = HandKind::kProgram;
    return header;
  }
  size_t HandedBack() const {
    auto tickets = *spool_->tickets().List();
    return static_cast<size_t>(std::ranges::count_if(tickets, &LockedTicket::handed_back));
  }
  Code Open(const char* pin) { return Safe().Open(ticket_.attempt, pin).status().code(); }

  test::TempFolder temp_;
  const fs::path folder_ = temp_.path();
  std::unique_ptr<Spool> spool_;
  trace::Ticket ticket_;
  int64_t now_ms_ = 1'700'000'000'000;
};

TEST_F(TicketSafeTest, RightPinGivesTheTicketBackAgainAndAgain) {
  ASSERT_TRUE(Put().ok());
  for (int i = 0; i < 3; ++i) {
    auto opened = Safe().Open(ticket_.attempt, kPin);
    ASSERT_TRUE(opened.ok()) << opened.status().message();
    EXPECT_EQ(*opened, ticket_);
  }
}

TEST_F(TicketSafeTest, WrongPinsWaitLongerEachTimeAndTheTenthDestroysTheTicket) {
  ASSERT_TRUE(Put().ok());
  int64_t expected_s = 30;
  for (int wrong = 1; wrong <= TicketSafe::kMaxTries; ++wrong) {
    ASSERT_EQ(Open(kOther), Code::kUnauthenticated) << wrong;
    if (wrong == TicketSafe::kMaxTries) break;
    if (wrong <= TicketSafe::kFreeTries) continue;
    // Before that, not even the right one is tested.
    now_ms_ += expected_s * 1000 - 1;
    EXPECT_EQ(Open(kPin), Code::kUnavailable) << wrong;
    now_ms_ += 1;
    expected_s *= 2;
  }
  EXPECT_EQ(Open(kPin), Code::kNotFound);
  EXPECT_EQ(HandedBack(), 1u) << "the server is told that it was not used";
}

// Each thread has its own connection, like a process.
TEST_F(TicketSafeTest, TriesAtTheSameMomentWinNoFurtherOne) {
  ASSERT_TRUE(Put().ok());
  constexpr int kThreads = 6;
  std::atomic<int> tried{0};
  std::vector<std::thread> threads;
  for (int i = 0; i < kThreads; ++i) {
    threads.emplace_back([&] {
      auto spool = Spool::Open(folder_);
      if (!spool.ok()) return;
      TicketSafe safe(**spool, [this] { return now_ms_; });
      auto opened = safe.Open(ticket_.attempt, kOther);
      tried += opened.status().code() == Code::kUnauthenticated ? 1 : 0;
    });
  }
  for (std::thread& t : threads) t.join();
  EXPECT_EQ(tried, TicketSafe::kFreeTries + 1);
  EXPECT_EQ((*spool_->tickets().List())[0].wrong_pins, TicketSafe::kFreeTries + 1);
  EXPECT_EQ(Open(kPin), Code::kUnavailable);
}

TEST_F(TicketSafeTest, RightPinBeginsTheCountAnew) {
  ASSERT_TRUE(Put().ok());
  for (int round = 0; round < 3; ++round) {
    EXPECT_EQ(Open(kOther), Code::kUnauthenticated);
    EXPECT_EQ(Open(kOther), Code::kUnauthenticated);
    EXPECT_EQ(Open(kPin), Code::kOk);
  }
}

TEST_F(TicketSafeTest, StartingTheProgramAgainWinsNoFurtherTry) {
  ASSERT_TRUE(Put().ok());
  for (int i = 0; i < 3; ++i) EXPECT_EQ(Open(kOther), Code::kUnauthenticated);
  spool_.reset();
  spool_ = std::move(*Spool::Open(folder_));
  EXPECT_EQ(Open(kPin), Code::kUnavailable);
  EXPECT_EQ(spool_->tickets().List()->front().wrong_pins, 3);
}

TEST_F(TicketSafeTest, ExpiredTicketIsHandedBackUnlessItWasBegun) {
  for (bool begun : {false, true}) {
    ticket_.attempt = Uuid::New();
    ticket_.expires_unix_ms = now_ms_ + 12 * kHour_ms;
    ASSERT_TRUE(Put().ok());
    if (begun) ASSERT_TRUE(spool_->BeginAttempt(Header(), "e", "p").ok());
    now_ms_ += 12 * kHour_ms - 1;
    EXPECT_EQ(Safe().List()->size(), 1u);
    now_ms_ += 1;
    EXPECT_TRUE(Safe().List()->empty());
    EXPECT_EQ(Open(kPin), Code::kNotFound);
    EXPECT_EQ(HandedBack(), begun ? 0u : 1u);
    ASSERT_TRUE(spool_->tickets().Remove(ticket_.attempt).ok());
  }
}

TEST_F(TicketSafeTest, WhatIsHandedBackOpensNothingAnyMore) {
  ASSERT_TRUE(Put().ok());
  ASSERT_TRUE(Safe().HandBack(ticket_.attempt).ok());
  EXPECT_TRUE(Safe().List()->empty());
  EXPECT_EQ(Open(kPin), Code::kNotFound);
  EXPECT_EQ(Safe().HandBack(ticket_.attempt).code(), Code::kNotFound);
  spool_.reset();
  spool_ = std::move(*Spool::Open(folder_));
  EXPECT_EQ(HandedBack(), 1u) << "until the server has been told";
  EXPECT_TRUE(spool_->tickets().List()->front().locked.empty());
}

TEST_F(TicketSafeTest, TicketThatWasBegunWithIsNotHandedBack) {
  ASSERT_TRUE(Put().ok());
  ASSERT_TRUE(spool_->BeginAttempt(Header(), "e", "p").ok());
  EXPECT_EQ(Safe().HandBack(ticket_.attempt).code(), Code::kConflict);
  EXPECT_EQ(Open(kPin), Code::kOk) << "its PIN may resume it";
}

// The ticket's own bytes and the PIN are nowhere on the disk.
TEST_F(TicketSafeTest, NeitherTicketNorPinIsOnTheDisk) {
  ticket_.signature.fill(0x5a);
  ASSERT_TRUE(Put().ok());
  const std::string needle(48, 0x5a);
  spool_.reset();
  for (const auto& entry : fs::directory_iterator(folder_)) {
    std::ifstream in(entry.path(), std::ios::binary);
    std::string bytes((std::istreambuf_iterator<char>(in)), {});
    EXPECT_EQ(bytes.find(needle), std::string::npos) << entry.path();
    EXPECT_EQ(bytes.find(kPin), std::string::npos) << entry.path();
  }
  spool_ = std::move(*Spool::Open(folder_));
  EXPECT_EQ(Safe().Open(ticket_.attempt, kPin)->signature, ticket_.signature);
}

}  // namespace
}  // namespace enamel::station
