#pragma once

#include <boost/asio/associated_executor.hpp>
#include <boost/asio/async_result.hpp>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/execution/outstanding_work.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/prefer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <memory>
#include <system_error>
#include <thread>
#include <type_traits>
#include <utility>
#include <vector>

#include "common/base/mutex.h"

namespace enamel::server {

// Where blocking work of coroutines runs (Store calls, decoding): a few threads, away from the I/O
// threads, each made when all others are busy. The coroutine continues on its own executor, so a session's strand still owns its data.
//
//   Result<Person> person = co_await pool.Run([&] { return store.PersonById(id); });
//
// References captured by the work stay valid because the coroutine's frame waits for it. The work
// must not throw. Thread safety: any thread. Destruction waits for all work.
class StorePool {
 public:
  explicit StorePool(size_t threads = 4) : most_(threads) {}
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
    namespace asio = boost::asio;
    auto begin = [this, &work](auto handler) {
      // Tracked: an io_context must not run out of work while only the pool is busy.
      auto back = asio::prefer(asio::get_associated_executor(handler),
                               asio::execution::outstanding_work.tracked);
      // std::function wants to copy it.
      auto shared = std::make_shared<decltype(handler)>(std::move(handler));
      Post([&work, back, shared] {
        auto finish = [handler = std::move(*shared), value = work()]() mutable {
          std::move(handler)(std::move(value));
        };
        asio::post(back, std::move(finish));
      });
    };
    co_return co_await asio::async_initiate<const asio::use_awaitable_t<>, void(T)>(
        begin, asio::use_awaitable);
  }

 private:
  using Task = std::function<void()>;

  void Post(Task task) {
    MutexLock lock(mutex_);
    tasks_.push_back(std::move(task));
    if (tasks_.size() <= idle_) {
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

  void Loop() {
    for (;;) {
      Task task;
      {
        MutexLock lock(mutex_);
        ++idle_;
        wake_.wait(mutex_, [&]() ENAMEL_REQUIRES(mutex_) { return stopping_ || !tasks_.empty(); });
        --idle_;
        if (tasks_.empty()) return;
        task = std::move(tasks_.front());
        tasks_.pop_front();
      }
      task();
    }
  }

  const size_t most_;
  Mutex mutex_;
  std::condition_variable_any wake_;
  std::deque<Task> tasks_ ENAMEL_GUARDED_BY(mutex_);
  size_t idle_ ENAMEL_GUARDED_BY(mutex_) = 0;
  bool stopping_ ENAMEL_GUARDED_BY(mutex_) = false;
  std::vector<std::jthread> threads_;  // grows under mutex_
};

}  // namespace enamel::server
