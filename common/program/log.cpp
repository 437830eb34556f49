#include "common/program/log.h"

#include <spdlog/formatter.h>
#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <array>
#include <boost/json.hpp>
#include <chrono>
#include <cstdlib>
#include <ctime>
#include <iostream>
#include <memory>
#include <string_view>
#include <utility>

#include "common/base/log_request.h"
#include "common/base/utf8.h"

namespace enamel::program {
namespace {

std::string UtcText(spdlog::log_clock::time_point time) {
  auto since = time.time_since_epoch();
  auto seconds = std::chrono::duration_cast<std::chrono::seconds>(since);
  auto ms = std::chrono::duration_cast<std::chrono::milliseconds>(since - seconds);
  std::time_t t = seconds.count();
  std::tm utc{};
  ::gmtime_r(&t, &utc);
  char day[32];
  std::strftime(day, sizeof day, "%Y-%m-%dT%H:%M:%S", &utc);
  char all[48];
  std::snprintf(all, sizeof all, "%s.%03dZ", day, static_cast<int>(ms.count()));
  return all;
}

// By which lines of one matter are found.
std::array<std::pair<const char*, std::string_view>, 2> Ids() {
  return {{{"request", LogRequest::Current()}, {"attempt", LogAttempt::Current()}}};
}

class JsonLines final : public spdlog::formatter {
 public:
  void format(const spdlog::details::log_msg& message, spdlog::memory_buf_t& out) override {
    auto level = spdlog::level::to_string_view(message.level);
    boost::json::object line{{"time", UtcText(message.time)},
                             {"level", boost::json::string_view(level.data(), level.size())},
                             {"message", AsUtf8({message.payload.data(), message.payload.size()})}};
    // A line is formatted by the thread that logs it.
    for (const auto& [name, id] : Ids()) {
      if (!id.empty()) line[name] = id;
    }
    std::string text = boost::json::serialize(line) + "\n";
    out.append(text.data(), text.data() + text.size());
  }
  std::unique_ptr<spdlog::formatter> clone() const override {
    return std::make_unique<JsonLines>();
  }
};

class IdsFlag final : public spdlog::custom_flag_formatter {
 public:
  void format(const spdlog::details::log_msg&, const std::tm&, spdlog::memory_buf_t& out) override {
    for (const auto& [name, id] : Ids()) {
      if (id.empty()) continue;
      const std::string text = "[" + std::string(name) + " " + std::string(id) + "] ";
      out.append(text.data(), text.data() + text.size());
    }
  }
  std::unique_ptr<custom_flag_formatter> clone() const override {
    return std::make_unique<IdsFlag>();
  }
};

// spdlog's own, with the ids before the message.
std::unique_ptr<spdlog::formatter> TextLines() {
  auto lines = std::make_unique<spdlog::pattern_formatter>();
  lines->add_flag<IdsFlag>('*').set_pattern("[%Y-%m-%d %H:%M:%S.%e] [%n] [%^%l%$] %*%v");
  return lines;
}

std::string program_name = "enamel";  // set before other threads
bool in_json = false;

void Say(spdlog::level::level_enum level, const std::string& message) {
  if (!in_json) {
    std::cerr << program_name << ": " << message << '\n';
    return;
  }
  auto logger = spdlog::default_logger();
  const auto wanted = logger->level();
  // For this one line: it is said whatever level was asked for.
  logger->set_level(level);
  logger->log(level, message);
  logger->set_level(wanted);
}

}  // namespace

Status SetUpLog(const LogOptions& options) {
  // Also says "off" to what it does not know; no log at all is not offered.
  auto level = spdlog::level::from_str(options.level);
  if (level == spdlog::level::off) {
    return Status(Code::kInvalidInput,
                  "expected the log level trace, debug, info, warning or error, found \"" +
                      options.level + "\"",
                  "log-level");
  }
  if (options.format != "text" && options.format != "json") {
    return Status(Code::kInvalidInput,
                  "expected the log format text or json, found \"" + options.format + "\"",
                  "log-format");
  }
  // Making a second logger of one name throws.
  spdlog::drop(options.name);
  if (options.format == "json") {
    auto logger = spdlog::stderr_logger_mt(options.name);
    logger->set_formatter(std::make_unique<JsonLines>());
    spdlog::set_default_logger(logger);
  } else {
    auto logger = spdlog::stderr_color_mt(options.name);
    logger->set_formatter(TextLines());
    spdlog::set_default_logger(logger);
  }
  spdlog::set_level(level);
  program_name = options.name;
  in_json = options.format == "json";
  return Status::Ok();
}

bool LogIsJson() { return in_json; }

bool AsksForJson(int argc, const char* const* argv, const std::string& prefix) {
  constexpr std::string_view kOption = "--log-format";
  for (int i = 1; i < argc; ++i) {
    const std::string_view word = argv[i];
    if (word == kOption) return i + 1 < argc && std::string_view(argv[i + 1]) == "json";
    if (word.starts_with(kOption) && word[kOption.size()] == '=') {
      return word.substr(kOption.size() + 1) == "json";
    }
  }
  const char* set = std::getenv((prefix + "LOG_FORMAT").c_str());
  return set != nullptr && std::string_view(set) == "json";
}

void SayError(const std::string& message) { Say(spdlog::level::err, message); }
void SayWarning(const std::string& message) { Say(spdlog::level::warn, message); }

}  // namespace enamel::program
