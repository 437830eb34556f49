#include "station/app/first_hour/person.h"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cstdio>

namespace enamel::station::first_hour {
namespace {

constexpr size_t kLongestLine = 1000, kLongestScript = 1 << 16;

std::string_view Trimmed(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r\n";
  const size_t from = text.find_first_not_of(kBlank);
  if (from == std::string_view::npos) return {};
  return text.substr(from, text.find_last_not_of(kBlank) + 1 - from);
}

// What JSON may hold of a line that was typed: control characters become blanks.
std::string Printable(std::string_view text) {
  std::string out(Trimmed(text.substr(0, kLongestLine)));
  std::ranges::replace_if(
      out, [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; }, ' ');
  return out;
}

Result<ScriptLine> ParseLine(std::string_view line) {
  const auto refused = [&](const char* expected) {
    return Status(Code::kInvalidInput, std::string("expected ") + expected + ", found '" +
                                           std::string(line.substr(0, 80)) + "'");
  };
  const size_t colon = line.find(':');
  if (colon == std::string_view::npos) return refused("ID: ANSWER or ID @SECONDS: ANSWER");
  std::string_view head = Trimmed(line.substr(0, colon));
  ScriptLine out;
  if (const size_t at = head.find('@'); at != std::string_view::npos) {
    const std::string_view after = Trimmed(head.substr(at + 1));
    const auto [end, error] =
        std::from_chars(after.data(), after.data() + after.size(), out.after_s);
    if (error != std::errc() || end != after.data() + after.size() ||
        !(out.after_s >= 0 && out.after_s <= 3600)) {
      return refused("0 to 3600 seconds behind the @");
    }
    head = Trimmed(head.substr(0, at));
  }
  if (head.empty()) return refused("the name of a question before the colon");
  out.id = head;
  out.answer = Printable(line.substr(colon + 1));
  return out;
}

}  // namespace

void Terminal::Tell(const std::string& text) {
  std::printf("%s\n", text.c_str());
  std::fflush(stdout);
}

void Terminal::Ask(const std::string&, const std::string& text) {
  // What was typed before the question answers nothing, least of all whether the motors may push.
  while (Listen(0).kind == Heard::Kind::kAnswer) {
  }
  read_.clear();
  std::printf("%s\n> ", text.c_str());
  std::fflush(stdout);
}

Heard Terminal::Listen(double) {
  pollfd input{STDIN_FILENO, POLLIN, 0};
  if (!closed_ && read_.find('\n') == std::string::npos && ::poll(&input, 1, 0) > 0) {
    char bytes[256];
    const ssize_t got = ::read(STDIN_FILENO, bytes, sizeof bytes);
    if (got <= 0) closed_ = true;
    if (got > 0) read_.append(bytes, static_cast<size_t>(got));
    // One that never ends a line is not kept.
    if (read_.size() > 2 * kLongestLine && read_.find('\n') == std::string::npos) read_.clear();
  }
  const size_t end = read_.find('\n');
  if (end == std::string::npos) {
    return {closed_ ? Heard::Kind::kClosed : Heard::Kind::kNothing};
  }
  Heard out{Heard::Kind::kAnswer, Printable(read_.substr(0, end))};
  read_.erase(0, end + 1);
  return out;
}

Result<std::vector<ScriptLine>> ParseScript(std::string_view text) {
  if (text.size() > kLongestScript) {
    return Status(Code::kTooLarge, "a file of answers has at most 64 KiB", "answers");
  }
  std::vector<ScriptLine> out;
  for (int number = 1; !text.empty(); ++number) {
    const size_t end = text.find('\n');
    const std::string_view line = Trimmed(text.substr(0, end));
    text = end == std::string_view::npos ? std::string_view{} : text.substr(end + 1);
    if (line.empty() || line.starts_with('#')) continue;
    auto parsed = ParseLine(line);
    if (!parsed.ok()) {
      return Status(parsed.status().code(),
                    "line " + std::to_string(number) + ": " + parsed.status().message(), "answers");
    }
    out.push_back(std::move(*parsed));
  }
  return out;
}

void Script::Ask(const std::string& id, const std::string& text) {
  shown_.Ask(id, text);
  asked_ = id;
  since_s_ = -1;
}

Heard Script::Listen(double now_s) {
  if (asked_.ends_with(".yes") && !consents_) return shown_.Listen(now_s);
  const auto line = std::ranges::find(lines_, asked_, &ScriptLine::id);
  if (line == lines_.end()) {
    shown_.Tell("The file of answers has none for '" + asked_ + "'.");
    return {Heard::Kind::kClosed};
  }
  if (since_s_ < 0) since_s_ = now_s;
  if (now_s - since_s_ < line->after_s) return {};
  Heard out{Heard::Kind::kAnswer, line->answer};
  lines_.erase(line);
  shown_.Tell(out.text);
  return out;
}

}  // namespace enamel::station::first_hour
