#pragma once

#include <algorithm>
#include <array>
#include <boost/asio/associated_executor.hpp>
#include <boost/asio/async_result.hpp>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/execution/outstanding_work.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/prefer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <exception>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <thread>
#include <type_traits>
#include <utility>
#include <vector>

#include "common/base/mutex.h"

namespace enamel::server {

// Who gets a thread first where many wait: every other turn is of kFirst, and of the other turns at
// least half are of kUsual.
enum class Line : uint8_t { kFirst, kUsual, kLast };

// Whose work it is, for a pool whose threads are shared out.
struct Turn {
  // A constructor, since g++ 12 destroys an aggregate within a co_await twice.
  explicit Turn(std::string whose = {}, Line in = Line::kUsual,
                size_t most_threads = std::numeric_limits<size_t>::max())
      : of(std::move(whose)), line(in), most(most_threads) {}
  std::string of;  // a person, an address; empty: nobody's in particular
  Line line = Line::kUsual;
  // Threads that it may have at once, in all lines together, where that is less than the pool's
  // `most_of_one`. A party gives the same number in each of its turns.
  size_t most = std::numeric_limits<size_t>::max();
};

// Where blocking work of coroutines runs (Store calls, decoding): a few threads, away from the I/O
// threads, each made when all others are busy. The coroutine continues on its own executor, so a session's strand still owns its data.
//
//   Result<Person> person = co_await pool.Run([&] { return store.PersonById(id); });
//
// Whoever has work that waits gets a thread in turn: nobody waits behind all of another's work.
//
// References captured by the work stay valid because the coroutine's frame waits for it. What the
// work throws, the coroutine throws. Thread safety: any thread. Destruction waits for all work.
class StorePool {
 public:
  // `most_of_one`: threads that one party may have at once.
  explicit StorePool(size_t threads = 4, size_t most_of_one = std::numeric_limits<size_t>::max())
      : most_(threads), most_of_one_(most_of_one) {}
  ~StorePool() {
    {
      MutexLock lock(mutex_);
      stopping_ = true;
    }
    wake_.notify_all();
    threads_.clear();  // joins
  }
  StorePool(const StorePool&) = delete;
  StorePool& operator=(const StorePool&) = delete;

  template <typename Work, typename T = std::invoke_result_t<Work>>
  boost::asio::awaitable<T> Run(Work work) {
    return Run(Turn(), std::move(work));
  }
  template <typename Work, typename T = std::invoke_result_t<Work>>
  boost::asio::awaitable<T> Run(Turn turn, Work work) {
    namespace asio = boost::asio;
    auto begin = [this, &turn, &work](auto handler) {
      // Tracked: an io_context must not run out of work while only the pool is busy.
      auto back = asio::prefer(asio::get_associated_executor(handler),
                               asio::execution::outstanding_work.tracked);
      // std::function wants to copy it.
      auto shared = std::make_shared<decltype(handler)>(std::move(handler));
      Post(turn, [&work, back, shared] {
        std::exception_ptr failure;
        std::optional<T> value;
        try {
          value.emplace(work());
        } catch (...) {
          failure = std::current_exception();
        }
        auto finish = [handler = std::move(*shared), failure, value = std::move(value)]() mutable {
          std::move(handler)(failure, std::move(value));
        };
        asio::post(back, std::move(finish));
      });
    };
    std::optional<T> value =
        co_await asio::async_initiate<const asio::use_awaitable_t<>,
                                      void(std::exception_ptr, std::optional<T>)>(
            begin, asio::use_awaitable);
    co_return std::move(*value);
  }

 private:
  using Task = std::function<void()>;
  static constexpr size_t kLines = 3;
  struct Party {
    std::array<std::deque<Task>, kLines> waiting{};  // by Line
    std::array<bool, kLines> in_line{};
    size_t most = 0;   // threads
    size_t taken = 0;  // of them: running, and in line for one
  };
  using Parties = std::map<std::string, Party>;  // by Turn::of

  void Post(const Turn& turn, Task task) {
    MutexLock lock(mutex_);
    const auto at = parties_.try_emplace(turn.of).first;
    at->second.most = std::min(most_of_one_, turn.most);
    at->second.waiting[static_cast<size_t>(turn.line)].push_back(std::move(task));
    Queue(at);
    if (lines_[0].size() + lines_[1].size() + lines_[2].size() <= idle_) {
      wake_.notify_one();
      return;
    }
    if (threads_.size() >= most_) return;
    try {
      threads_.emplace_back([this] { Loop(); });
    } catch (const std::system_error&) {
      // The machine has no more threads: those that there are do it.
      if (threads_.empty()) throw;
    }
  }

  // Puts the party at the end of each line in which its work waits, if it may have a thread more.
  void Queue(Parties::iterator at) ENAMEL_REQUIRES(mutex_) {
    Party& party = at->second;
    for (size_t line = 0; line < kLines; ++line) {
      if (party.in_line[line] || party.waiting[line].empty() || party.taken >= party.most) continue;
      party.in_line[line] = true;
      ++party.taken;
      lines_[line].push_back(at);
    }
  }

  // Whose turn it is. Requires: somebody is in a line.
  size_t NextLine() ENAMEL_REQUIRES(mutex_) {
    const bool others = !lines_[1].empty() || !lines_[2].empty();
    const bool first = !lines_[0].empty() && !(others && first_had_turn_);
    first_had_turn_ = first;
    if (first) return 0;
    const bool last = lines_[1].empty() || (!lines_[2].empty() && usual_had_turn_);
    usual_had_turn_ = !last;
    return last ? 2 : 1;
  }

  void Loop() {
    MutexLock lock(mutex_);
    for (;;) {
      const auto any = [&]() ENAMEL_REQUIRES(mutex_) {
        return !lines_[0].empty() || !lines_[1].empty() || !lines_[2].empty();
      };
      ++idle_;
      wake_.wait(mutex_, [&]() ENAMEL_REQUIRES(mutex_) { return stopping_ || any(); });
      --idle_;
      if (!any()) return;
      const size_t line = NextLine();
      const Parties::iterator at = lines_[line].front();
      lines_[line].pop_front();
      at->second.in_line[line] = false;
      Task task = std::move(at->second.waiting[line].front());
      at->second.waiting[line].pop_front();
      Queue(at);
      mutex_.unlock();
      task();
      task = nullptr;
      mutex_.lock();
      --at->second.taken;
      Queue(at);
      // All that waits is in line, or follows what runs.
      if (at->second.taken == 0) parties_.erase(at);
    }
  }

  const size_t most_, most_of_one_;
  Mutex mutex_;
  std::condition_variable_any wake_;
  Parties parties_ ENAMEL_GUARDED_BY(mutex_);
  std::array<std::deque<Parties::iterator>, kLines> lines_ ENAMEL_GUARDED_BY(mutex_);  // by Line
  bool first_had_turn_ ENAMEL_GUARDED_BY(mutex_) = false;
  bool usual_had_turn_ ENAMEL_GUARDED_BY(mutex_) = false;
  size_t idle_ ENAMEL_GUARDED_BY(mutex_) = 0;
  bool stopping_ ENAMEL_GUARDED_BY(mutex_) = false;
  std::vector<std::jthread> threads_;  // grows under mutex_
};

}  // namespace enamel::server
