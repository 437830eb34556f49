#pragma once

#include <boost/asio/associated_executor.hpp>
#include <boost/asio/async_result.hpp>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/execution/outstanding_work.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/prefer.hpp>
#include <boost/asio/thread_pool.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <cstddef>
#include <type_traits>
#include <utility>

namespace enamel::server {

// Where blocking work of coroutines runs (Store calls, decoding): a few threads, away from the I/O
// threads. The coroutine continues on its own executor, so a session's strand still owns its data.
//
//   Result<Person> person = co_await pool.Run([&] { return store.PersonById(id); });
//
// References captured by the work stay valid because the coroutine's frame waits for it. The work
// must not throw. Thread safety: any thread. Destruction waits for work that has begun.
class StorePool {
 public:
  explicit StorePool(size_t threads = 4) : pool_(threads) {}
  ~StorePool() { pool_.join(); }
  StorePool(const StorePool&) = delete;
  StorePool& operator=(const StorePool&) = delete;

  template <typename Work, typename T = std::invoke_result_t<Work>>
  boost::asio::awaitable<T> Run(Work work) {
    namespace asio = boost::asio;
    auto begin = [this, &work](auto handler) {
      // Tracked: an io_context must not run out of work while only the pool is busy.
      auto back = asio::prefer(asio::get_associated_executor(handler),
                               asio::execution::outstanding_work.tracked);
      asio::post(pool_, [&work, back, handler = std::move(handler)]() mutable {
        auto finish = [handler = std::move(handler), value = work()]() mutable {
          std::move(handler)(std::move(value));
        };
        asio::post(back, std::move(finish));
      });
    };
    co_return co_await asio::async_initiate<const asio::use_awaitable_t<>, void(T)>(
        begin, asio::use_awaitable);
  }

 private:
  boost::asio::thread_pool pool_;
};

}  // namespace enamel::server
