#pragma once

#include <spdlog/sinks/base_sink.h>
#include <spdlog/sinks/dist_sink.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <memory>
#include <mutex>
#include <string>

namespace enamel::station {

// The log of this test program, set before its threads begin: a logger must not be replaced while
// another thread writes to it.
inline const std::shared_ptr<spdlog::sinks::dist_sink_mt> kLog = [] {
  auto all = std::make_shared<spdlog::sinks::dist_sink_mt>();
  all->add_sink(std::make_shared<spdlog::sinks::stderr_sink_mt>());
  spdlog::set_default_logger(std::make_shared<spdlog::logger>("test", all));
  return all;
}();

// Messages logged during this object's lifetime, one a line with its level before it: "info: …".
// Thread safety: all.
class LogLines {
 public:
  LogLines() { kLog->add_sink(sink_); }
  ~LogLines() { kLog->remove_sink(sink_); }
  LogLines(const LogLines&) = delete;
  LogLines& operator=(const LogLines&) = delete;

  std::string text() const { return sink_->text(); }
  bool Has(const std::string& words) const { return text().find(words) != std::string::npos; }

 private:
  class Sink final : public spdlog::sinks::base_sink<std::mutex> {
   public:
    std::string text() {
      std::lock_guard lock(mutex_);
      return text_;
    }

   private:
    void sink_it_(const spdlog::details::log_msg& message) override {
      const auto level = spdlog::level::to_string_view(message.level);
      text_.append(level.data(), level.size()).append(": ");
      text_.append(message.payload.data(), message.payload.size()).append("\n");
    }
    void flush_() override {}
    std::string text_;
  };

  const std::shared_ptr<Sink> sink_ = std::make_shared<Sink>();
};

}  // namespace enamel::station
