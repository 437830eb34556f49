#pragma once

#include <array>
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

// Texts for people, in their language: ICU messages in catalogues, one file for each language and
// part of the program, built into it: schemas/words.md, schemas/words/.
namespace enamel::language {

enum class Language { kEnglish, kGerman, kChinese };
inline constexpr std::array kLanguages = {Language::kEnglish, Language::kGerman,
                                          Language::kChinese};

std::string_view CodeOf(Language language);  // "en", "de", "zh"
std::string_view NameOf(
    Language language);  // as its speakers write it: "English", "Deutsch", "中文"

// The language of a code (BCP 47) or a locale's name, by its first part: "de", "de-CH",
// "zh_CN.UTF-8". None: no such language here.
std::optional<Language> LanguageOf(std::string_view code);

// The value of a place {name} in a message. Numbers decide on plurals. Use Decimal for numbers with
// decimals: only the code that measured a value knows how many digits it deserves.
struct Value {
  std::string_view name;
  std::variant<int64_t, std::string> value;
};

// The messages of one language. Thread safety: an object belongs to one thread at a time. Not for
// the haptic loop: the first use of a message parses it.
class Words {
 public:
  explicit Words(Language language);
  ~Words();
  Words(Words&&) noexcept;
  Words& operator=(Words&&) noexcept;

  Language language() const;

  // The message of this key ("sign_in.login"), its places filled. A key that no catalogue has is
  // returned unchanged: a test finds it (tests/common/language), and a person can report it.
  std::string Say(std::string_view key, std::initializer_list<Value> values = {}) const {
    return Say(key, std::span<const Value>(values.begin(), values.size()));
  }
  // Where how many places a message has is known only when it is said.
  std::string Say(std::string_view key, std::span<const Value> values) const;
  // False: no catalogue has this key, which may come from somebody else's text.
  bool Has(std::string_view key) const;
  // With exactly `digits` digits after the point, or the comma: 0.30, 0,30.
  std::string Decimal(double value, int digits) const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

// A key and its message, for tests and for programs that draw letters: every text consists of
// these.
struct Message {
  std::string key, pattern;
};
// Sorted by key.
std::span<const Message> MessagesOf(Language language);
// The places of a message, sorted; none where it is not a message, with the reason.
struct Places {
  std::vector<std::string> names;
  std::string problem;  // empty: none
};
Places PlacesOf(Language language, std::string_view pattern);

}  // namespace enamel::language
