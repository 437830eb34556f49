#include "server/doctor/scrub.h"

#include <arpa/inet.h>
#include <sodium.h>

#include <algorithm>

#include "common/base/bytes.h"
#include "common/base/uuid.h"

namespace enamel::server::app {
namespace {

constexpr size_t kLongRun = 20;

bool IsLetter(unsigned char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c >= 0x80;
}
bool IsDigit(unsigned char c) { return c >= '0' && c <= '9'; }
// Parts of names, addresses, keys: what a space or punctuation ends.
bool IsOfWord(unsigned char c) {
  return IsLetter(c) || IsDigit(c) || c == '-' || c == '_' || c == '.' || c == '@' || c == ':' ||
         c == '+' || c == '/' || c == '%';
}

std::string Lower(std::string_view text) {
  std::string out(text);
  std::ranges::transform(out, out.begin(), [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  });
  return out;
}

// Numeric; with a port or not.
bool IsAddress(std::string_view word) {
  in_addr v4{};
  in6_addr v6{};
  const std::string text(word), host = text.substr(0, text.rfind(':'));
  return ::inet_pton(AF_INET, text.c_str(), &v4) == 1 ||
         ::inet_pton(AF_INET, host.c_str(), &v4) == 1 ||
         (text.find(':') != std::string::npos && ::inet_pton(AF_INET6, text.c_str(), &v6) == 1);
}

// No word is written so: one of 250 keys of 32 characters of base64 is without a digit.
bool IsOfAKey(std::string_view run) {
  const auto capitals = std::ranges::count_if(run, [](char c) { return c >= 'A' && c <= 'Z'; });
  const auto small = std::ranges::count_if(run, [](char c) { return c >= 'a' && c <= 'z'; });
  const bool digits =
      std::ranges::any_of(run, [](char c) { return IsDigit(static_cast<unsigned char>(c)); });
  return digits || (capitals > 1 && small > 1);
}

// A token, a key, a hash: long, and neither a word nor a path of words.
bool IsLongRun(std::string_view word) {
  for (size_t begin = 0, i = 0; i <= word.size(); ++i) {
    const auto c = static_cast<unsigned char>(i < word.size() ? word[i] : ' ');
    if ((IsLetter(c) && c < 0x80) || IsDigit(c) || c == '+' || c == '=') continue;
    const std::string_view run = word.substr(begin, i - begin);
    if (run.size() >= kLongRun && IsOfAKey(run)) return true;
    begin = i + 1;
  }
  return false;
}

}  // namespace

Scrubber::Scrubber(std::set<std::string> names, const std::set<std::string>& hosts) {
  for (const std::string& name : names) {
    if (name.size() > 1) names_.insert(Lower(name));
  }
  // Name no school, and are words of paths and messages.
  static const std::set<std::string> kNamesNobody{"", "enamel", "localhost", "server", "www"};
  for (const std::string& given : hosts) {
    const std::string host = Lower(given);
    if (IsAddress(host)) continue;
    const size_t dot = host.find('.');
    const std::string label = host.substr(0, dot);
    if (!kNamesNobody.contains(label)) hosts_.insert(label);
    if (dot == std::string::npos) continue;
    const std::string domain = host.substr(dot + 1);
    domains_.insert(domain.find('.') == std::string::npos ? host : domain);
  }
  randombytes_buf(salt_.bytes.data(), salt_.bytes.size());
}

bool Scrubber::IsHost(std::string_view word) const {
  const std::string host = Lower(word);
  return hosts_.contains(host) || std::ranges::any_of(domains_, [&](const std::string& domain) {
           return host == domain || host.ends_with("." + domain);
         });
}

std::string Scrubber::OtherId(std::string_view id) const {
  Bytes bytes(salt_.bytes.begin(), salt_.bytes.end());
  bytes.insert(bytes.end(), id.begin(), id.end());
  return "id-" + HashSha256(bytes).Hex().substr(0, 8);
}

std::string Scrubber::Word(std::string_view word) const {
  // A full stop or a colon at the end belongs to the sentence.
  std::string_view end;
  while (!word.empty() && (word.back() == '.' || word.back() == ':')) {
    end = std::string_view(word.data() + word.size() - 1, end.size() + 1);
    word.remove_suffix(1);
  }
  std::string out(word);
  if (names_.contains(Lower(word))) {
    out = "[name]";
  } else if (Uuid::Parse(word).ok()) {
    out = OtherId(word);
  } else if (IsAddress(word)) {
    out = "[address]";
  } else if (word.find('@') != std::string_view::npos) {
    out = "[mail]";
  } else if (IsLongRun(word)) {
    out = "[secret]";
  } else {
    // "enamel/anna": its parts.
    std::string parts;
    for (size_t begin = 0; begin < word.size();) {
      const size_t part = std::min(word.find_first_of("/:_", begin), word.size());
      const std::string_view one = word.substr(begin, part - begin);
      parts += names_.contains(Lower(one)) ? "[name]" : IsHost(one) ? "[host]" : std::string(one);
      if (part < word.size()) parts += word[part];
      begin = part + 1;
    }
    out = parts;
  }
  return out + std::string(end);
}

std::string Scrubber::Scrubbed(std::string_view text, bool quoted) const {
  std::string source(text);
  // Names of several words first: their words may be others' names.
  for (const std::string& name : names_) {
    if (name.find(' ') == std::string::npos) continue;
    for (size_t at = 0; (at = Lower(source).find(name, at)) != std::string::npos;) {
      source.replace(at, name.size(), "[name]");
    }
  }
  std::string out;
  for (size_t i = 0; i < source.size();) {
    const char c = source[i];
    const size_t close = c == '"' || c == '\'' ? source.find(c, i + 1) : std::string::npos;
    const bool opens = i == 0 || !IsOfWord(static_cast<unsigned char>(source[i - 1]));
    if (quoted && close != std::string::npos && opens) {
      out += std::string(1, c) + "[text]" + c;
      i = close + 1;
    } else if (IsOfWord(static_cast<unsigned char>(c))) {
      size_t end = i;
      while (end < source.size() && IsOfWord(static_cast<unsigned char>(source[end]))) ++end;
      out += Word(std::string_view(source).substr(i, end - i));
      i = end;
    } else {
      out += c;
      ++i;
    }
  }
  return out;
}

}  // namespace enamel::server::app
