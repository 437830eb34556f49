#include "server/net/deadline.h"

#include <boost/asio/redirect_error.hpp>
#include <boost/asio/use_awaitable.hpp>

namespace enamel::server {

namespace asio = boost::asio;

void Deadline::Allow(std::chrono::milliseconds time) {
  at_ = Clock::now() + time;
  if (at_ < timer_.expiry()) timer_.expires_at(at_);
}

asio::awaitable<bool> Deadline::Watch() {
  while (!ended_) {
    if (at_ <= Clock::now()) {
      passed_ = true;
      co_return true;
    }
    timer_.expires_at(at_);
    boost::system::error_code moved;
    co_await timer_.async_wait(asio::redirect_error(asio::use_awaitable, moved));
  }
  co_return false;
}

void Deadline::End() {
  ended_ = true;
  timer_.cancel();
}

}  // namespace enamel::server
