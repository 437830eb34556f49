#include "common/language/words.h"

#include <unicode/messagepattern.h>
#include <unicode/msgfmt.h>

#include <algorithm>
#include <boost/json.hpp>
#include <charconv>
#include <map>
#include <set>
#include <utility>

#include "common/language/catalogues.h"

namespace enamel::language {
namespace {

struct Spoken {
  std::string_view code, name;
  const char* locale;
  char point;  // between a number and its decimals
};
// In the order of Language. Digits are not grouped: nothing here reaches ten thousand but counts of
// parts.
constexpr std::array<Spoken, kLanguages.size()> kSpoken = {
    Spoken{"en", "English", "en", '.'},
    Spoken{"de", "Deutsch", "de", ','},
    Spoken{"zh", "中文", "zh_Hans", '.'},
};
const Spoken& SpokenOf(Language language) { return kSpoken[static_cast<size_t>(language)]; }

icu::UnicodeString Unicode(std::string_view text) {
  return icu::UnicodeString::fromUTF8(icu::StringPiece(text.data(), static_cast<int>(text.size())));
}

std::vector<Message> Read(Language language) {
  std::vector<Message> out;
  for (const Catalogue& file : Catalogues()) {
    if (file.language != CodeOf(language)) continue;
    // Part of the program, not from outside: a file that is no catalogue fails every test here, and
    // the first use.
    const boost::json::value document = boost::json::parse(file.text);
    for (const auto& [key, pattern] : document.at("messages").as_object()) {
      out.push_back({std::string(key), std::string(pattern.as_string())});
    }
  }
  std::ranges::sort(out, {}, &Message::key);
  return out;
}

const Message* Find(Language language, std::string_view key) {
  const auto all = MessagesOf(language);
  const auto at = std::ranges::lower_bound(all, key, {}, &Message::key);
  return at != all.end() && at->key == key ? &*at : nullptr;
}

}  // namespace

std::string_view CodeOf(Language language) { return SpokenOf(language).code; }
std::string_view NameOf(Language language) { return SpokenOf(language).name; }

std::optional<Language> LanguageOf(std::string_view code) {
  const std::string_view first = code.substr(0, code.find_first_of("-_.@"));
  for (Language language : kLanguages) {
    if (first == CodeOf(language)) return language;
  }
  return std::nullopt;
}

std::span<const Message> MessagesOf(Language language) {
  static const auto kAll = [] {
    std::array<std::vector<Message>, kLanguages.size()> all;
    for (Language each : kLanguages) all[static_cast<size_t>(each)] = Read(each);
    return all;
  }();
  return kAll[static_cast<size_t>(language)];
}

Places PlacesOf(Language language, std::string_view pattern) {
  UErrorCode error = U_ZERO_ERROR;
  UParseError where{};
  const icu::MessagePattern parsed(Unicode(pattern), &where, error);
  // A format knows more than the pattern: whether the plural's kinds are this language's.
  const icu::MessageFormat format(Unicode(pattern), icu::Locale(SpokenOf(language).locale), where,
                                  error);
  if (U_FAILURE(error)) {
    return {{}, std::string(u_errorName(error)) + " at letter " + std::to_string(where.offset)};
  }
  std::set<std::string> names;
  for (int i = 0; i < parsed.countParts(); ++i) {
    const auto& part = parsed.getPart(i);
    if (part.getType() != UMSGPAT_PART_TYPE_ARG_NAME) continue;
    std::string name;
    parsed.getSubstring(part).toUTF8String(name);
    names.insert(name);
  }
  return {{names.begin(), names.end()}, ""};
}

class Words::Impl {
 public:
  explicit Impl(Language spoken) : language(spoken), locale(SpokenOf(spoken).locale) {}

  // Null: no such key.
  const icu::MessageFormat* FormatOf(std::string_view key) {
    if (auto known = formats.find(key); known != formats.end()) return known->second.get();
    const Message* message = Find(language, key);
    if (message == nullptr) return nullptr;
    UErrorCode error = U_ZERO_ERROR;
    auto format = std::make_unique<icu::MessageFormat>(Unicode(message->pattern), locale, error);
    if (U_FAILURE(error)) return nullptr;
    return formats.emplace(message->key, std::move(format)).first->second.get();
  }

  Language language;
  icu::Locale locale;
  std::map<std::string, std::unique_ptr<icu::MessageFormat>, std::less<>> formats;
};

Words::Words(Language language) : impl_(std::make_unique<Impl>(language)) {}
Words::~Words() = default;
Words::Words(Words&&) noexcept = default;
Words& Words::operator=(Words&&) noexcept = default;

Language Words::language() const { return impl_->language; }

bool Words::Has(std::string_view key) const { return Find(impl_->language, key) != nullptr; }

std::string Words::Say(std::string_view key, std::span<const Value> values) const {
  const icu::MessageFormat* format = impl_->FormatOf(key);
  if (format == nullptr) return std::string(key);
  std::vector<icu::UnicodeString> names;
  std::vector<icu::Formattable> filled;
  for (const Value& each : values) {
    names.push_back(Unicode(each.name));
    if (const auto* number = std::get_if<int64_t>(&each.value)) {
      filled.emplace_back(*number);
    } else {
      filled.emplace_back(Unicode(std::get<std::string>(each.value)));
    }
  }
  UErrorCode error = U_ZERO_ERROR;
  icu::UnicodeString said;
  format->format(names.data(), filled.data(), static_cast<int>(filled.size()), said, error);
  if (U_FAILURE(error)) return std::string(key);
  std::string out;
  said.toUTF8String(out);
  return out;
}

std::string Words::Decimal(double value, int digits) const {
  // Long enough for any double.
  std::array<char, 400> text;
  const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), value,
                                          std::chars_format::fixed, digits);
  std::string out(text.data(), error == std::errc() ? end : text.data());
  std::ranges::replace(out, '.', SpokenOf(impl_->language).point);
  return out;
}

}  // namespace enamel::language
