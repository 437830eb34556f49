#include "server/storage/store_pool.h"

#include <gtest/gtest.h>

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/io_context.hpp>
#include <exception>
#include <semaphore>
#include <stdexcept>
#include <string>
#include <thread>

#include "common/base/mutex.h"

// Whose work gets a thread when.
namespace enamel::server {
namespace {

class StorePoolTest : public ::testing::Test {
 protected:
  // Notes its name once it has a thread, which it keeps until `go`.
  void Post(StorePool& pool, const Turn& turn, const std::string& name) {
    boost::asio::co_spawn(
        io_,
        [this, &pool, turn, name]() -> boost::asio::awaitable<void> {
          co_await pool.Run(turn, [&] {
            {
              MutexLock lock(mutex_);
              order_ += name;
            }
            begun_.release();
            go_.acquire();
            return true;
          });
        },
        boost::asio::detached);
    // It is in the pool's line.
    io_.restart();
    io_.poll();
  }
  void Finish(int count) {
    go_.release(count);
    io_.restart();
    io_.run();
  }
  std::string order() {
    MutexLock lock(mutex_);
    return order_;
  }

  boost::asio::io_context io_;
  std::counting_semaphore<> begun_{0}, go_{0};
  Mutex mutex_;
  std::string order_ ENAMEL_GUARDED_BY(mutex_);
};

TEST_F(StorePoolTest, NobodyWaitsBehindAllOfAnothersWork) {
  StorePool pool(1);
  Post(pool, Turn("many"), "a");
  begun_.acquire();
  for (const char* name : {"b", "c", "d"}) Post(pool, Turn("many"), name);
  Post(pool, Turn("few"), "X");
  Post(pool, Turn("few"), "Y");
  Finish(6);
  EXPECT_EQ(order(), "abXcYd");
}

TEST_F(StorePoolTest, ThoseWhoGoFirstGetEveryOtherTurn) {
  StorePool pool(1);
  Post(pool, Turn("guesser"), "a");
  begun_.acquire();
  for (const char* name : {"b", "c"}) Post(pool, Turn("guesser"), name);
  for (const char* name : {"1", "2", "3"}) Post(pool, Turn(name, Line::kFirst), name);
  Finish(6);
  EXPECT_EQ(order(), "a1b2c3");
}

TEST_F(StorePoolTest, ThoseWhoGoLastGetATurnInFour) {
  StorePool pool(1);
  Post(pool, Turn("guesser", Line::kLast), "a");
  begun_.acquire();
  for (const char* name : {"b", "c", "d"}) Post(pool, Turn(name, Line::kLast), name);
  for (const char* name : {"X", "Y"}) Post(pool, Turn(name), name);
  for (const char* name : {"1", "2", "3"}) Post(pool, Turn(name, Line::kFirst), name);
  Finish(9);
  EXPECT_EQ(order(), "a1X2b3Ycd");
}

TEST_F(StorePoolTest, OneHasAsManyThreadsAsOneMayHave) {
  StorePool pool(2, 1);
  Post(pool, Turn("many"), "a");
  Post(pool, Turn("many"), "b");
  begun_.acquire();
  Post(pool, Turn("few"), "X");
  begun_.acquire();
  EXPECT_EQ(order(), "aX") << "the second thread is for others";
  Finish(3);
  EXPECT_EQ(order().size(), 3u);
}

TEST_F(StorePoolTest, APartyHasAsManyThreadsAsItsTurnSays) {
  StorePool pool(2);
  Post(pool, Turn("one", Line::kUsual, 1), "a");
  Post(pool, Turn("one", Line::kUsual, 1), "b");
  Post(pool, Turn("one", Line::kFirst, 1), "c");  // in whatever line
  begun_.acquire();
  Post(pool, Turn("other"), "X");
  begun_.acquire();
  EXPECT_EQ(order(), "aX");
  Finish(4);
  EXPECT_EQ(order().size(), 4u);
}

TEST_F(StorePoolTest, WhoWaitsForWorkThrowsWhatItThrew) {
  StorePool pool(1);
  std::string caught;
  boost::asio::co_spawn(
      io_,
      [&]() -> boost::asio::awaitable<void> {
        co_await pool.Run([]() -> bool { throw std::runtime_error("no memory"); });
      },
      [&](std::exception_ptr failure) {
        try {
          if (failure) std::rethrow_exception(failure);
        } catch (const std::runtime_error& error) {
          caught = error.what();
        }
      });
  io_.run();
  EXPECT_EQ(caught, "no memory");
  Post(pool, Turn("next"), "a");
  begun_.acquire();
  Finish(1);
  EXPECT_EQ(order(), "a") << "the thread is still there";
}

}  // namespace
}  // namespace enamel::server
