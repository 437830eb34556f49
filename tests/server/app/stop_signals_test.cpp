#include "server/app/stop_signals.h"

#include <gtest/gtest.h>

#include <semaphore>

namespace enamel::server::app {
namespace {

// Asks the program to end at once, and hangs.
[[noreturn]] void HangAfterStop(bool only_jobs_remain) {
  boost::asio::io_context io;
  StopSignals signals(io);
  if (only_jobs_remain) signals.OnlyJobsRemain();
  signals.EndSoon(std::chrono::milliseconds(1));
  std::binary_semaphore never(0);
  for (;;) never.acquire();
}

TEST(StopSignalsTest, ChangesWithoutAnAnswerEndItWithOne) {
  EXPECT_EXIT(HangAfterStop(false), ::testing::ExitedWithCode(1), "");
}

TEST(StopSignalsTest, AJobThatHangsIsLeftAndNoFailure) {
  EXPECT_EXIT(HangAfterStop(true), ::testing::ExitedWithCode(0), "");
}

}  // namespace
}  // namespace enamel::server::app
