#include "server/auth/guesses.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <limits>
#include <optional>
#include <unordered_map>
#include <utility>

#include "server/auth/common_passwords.h"

namespace enamel::server::auth {
namespace {

// What comes after it is not counted: whoever gets as far has a sentence, or one character 64
// times.
constexpr size_t kLongestLookedAt = 64;
// Of more pieces the rest counts as characters that nothing explains.
constexpr size_t kMaxPieces = 12;
constexpr size_t kShortestWord = 3;
constexpr double kYears = 120;

// Words of dentistry and of German-speaking schools, which the list of leaked ones lacks.
constexpr std::string_view kWordsAtHand[] = {
    "passwort", "kennwort", "willkommen", "geheim", "hallo", "schatz", "enamel", "dentin", "dental",
    "dentist", "dentistry", "tooth", "teeth", "molar", "incisor", "cavity", "zahn", "zahnarzt",
    "zahnmedizin", "schule", "student", "instructor", "teacher", "university", "universität",
    "klinik", "clinic", "station", "bench", "demo", "sommer", "herbst", "frühling", "winter",
    "spring", "summer", "autumn", "administrator", "changeme", "default", "contrasena",
    "motdepasse", "bonjour", "soleil",
    // The example that everybody has read (xkcd 936).
    "correcthorsebatterystaple"};
constexpr int kRankAtHand = 200;

struct Piece {
  size_t begin, end;
  double log10;
};

char LowerOf(char c) { return static_cast<char>(std::tolower(static_cast<unsigned char>(c))); }
bool IsDigit(char c) { return c >= '0' && c <= '9'; }
bool IsUpper(char c) { return c >= 'A' && c <= 'Z'; }
bool IsLower(char c) { return c >= 'a' && c <= 'z'; }

std::string LowerText(std::string_view text) {
  std::string out(text);
  std::ranges::transform(out, out.begin(), LowerOf);
  return out;
}

// The letters U+00C0 to U+00FF without their marks: "Zürich" as "Zurich".
std::string WithoutMarks(std::string_view utf8) {
  constexpr std::string_view kBase =
      "AAAAAAACEEEEIIIIDNOOOOOxOUUUUYTsaaaaaaaceeeeiiiidnooooo/ouuuuyty";
  std::string out;
  for (size_t i = 0; i < utf8.size(); ++i) {
    const auto next = i + 1 < utf8.size() ? static_cast<unsigned char>(utf8[i + 1]) : 0u;
    if (utf8[i] == '\xC3' && next >= 0x80 && next < 0xC0) {
      out += kBase[next - 0x80];
      ++i;
    } else {
      out += utf8[i];
    }
  }
  return out;
}

// A letter and what is written for it become one, so that "p@ssw0rd" and "password" do, and "q1w233"
// and "q1w2e3".
std::string Undressed(std::string text) {
  constexpr std::string_view kShown = "0125346789@$!+(|i";
  constexpr std::string_view kMeant = "olzseagtbgasltcll";
  for (char& c : text) {
    if (size_t at = kShown.find(c); at != std::string_view::npos) c = kMeant[at];
  }
  return text;
}

// Of the commonest word that becomes the same; 0: of none.
int UndressedRank(const std::string& undressed) {
  static const std::unordered_map<std::string, int> kRanks = [] {
    std::unordered_map<std::string, int> out;
    int rank = 0;
    for (std::string_view one : CommonPasswords()) {
      out.emplace(Undressed(std::string(one)), ++rank);
    }
    for (std::string_view one : kWordsAtHand) {
      int& kept = out.try_emplace(Undressed(std::string(one)), kRankAtHand).first->second;
      kept = std::min(kept, kRankAtHand);
    }
    return out;
  }();
  auto found = kRanks.find(undressed);
  return found == kRanks.end() ? 0 : found->second;
}

// In how many ways it can be written in capitals: none, the usual ones, or any.
double LogOfCapitals(std::string_view text) {
  const auto upper = std::ranges::count_if(text, IsUpper);
  const auto lower = std::ranges::count_if(text, IsLower);
  if (upper == 0) return 0;
  const bool usual = lower == 0 || (upper == 1 && (IsUpper(text.front()) || IsUpper(text.back())));
  if (usual) return std::log10(2.0);
  return static_cast<double>(std::min(upper, lower)) * std::log10(static_cast<double>(text.size()));
}

// A password, read in every way that matters, and the pieces found in it.
class Reading {
 public:
  Reading(std::string_view text, const std::vector<std::string>& known)
      : text_(text), lower_(LowerText(text)), known_(known) {}

  double Log10() {
    AddWords();
    AddSequences();
    AddWalks();
    AddDates();
    AddRepeats();
    return Cheapest();
  }

 private:
  void Add(size_t begin, size_t end, double guesses, double more_log10 = 0) {
    pieces_.push_back({begin, end, std::log10(guesses) + more_log10});
  }

  int RankOf(std::string_view word) const {
    if (std::ranges::find(known_, word) != known_.end()) return 1;
    int rank = CommonRank(word);
    bool at_hand = std::ranges::find(kWordsAtHand, word) != std::end(kWordsAtHand);
    return at_hand && (rank == 0 || rank > kRankAtHand) ? kRankAtHand : rank;
  }

  int DisguisedRankOf(std::string_view word) const {
    const std::string undressed = Undressed(std::string(word));
    auto same = [&](const std::string& one) { return Undressed(one) == undressed; };
    return std::ranges::any_of(known_, same) ? 1 : UndressedRank(undressed);
  }

  void AddWords() {
    AddWordsOf(lower_, false);
    AddWordsOf(std::string(lower_.rbegin(), lower_.rend()), true);
  }

  void AddWordsOf(const std::string& reading, bool backwards) {
    const size_t n = reading.size();
    const double more_log10 = backwards ? std::log10(2.0) : 0;
    for (size_t i = 0; i < n; ++i) {
      for (size_t end = i + kShortestWord; end <= n; ++end) {
        const std::string_view word = std::string_view(reading).substr(i, end - i);
        const size_t from = backwards ? n - end : i, to = backwards ? n - i : end;
        const double capitals = LogOfCapitals(text_.substr(from, to - from));
        if (int rank = RankOf(word); rank > 0) Add(from, to, rank, more_log10 + capitals);
        if (int rank = DisguisedRankOf(word); rank > 0) {
          Add(from, to, 2.0 * rank, more_log10 + capitals);
        }
      }
    }
  }

  // "abcd", "8642": the same step again and again.
  void AddSequences() {
    constexpr int kLargestStep = 5;
    for (size_t i = 0; i + 2 < lower_.size();) {
      const int step = lower_[i + 1] - lower_[i];
      size_t end = i + 2;
      while (end < lower_.size() && lower_[end] - lower_[end - 1] == step) ++end;
      const bool same_kind = IsDigit(lower_[i]) == IsDigit(lower_[end - 1]);
      if (end - i >= 3 && step != 0 && std::abs(step) <= kLargestStep && same_kind) {
        AddSequence(i, end, step);
      }
      i = end - 1;
    }
  }

  void AddSequence(size_t begin, size_t end, int step) {
    const char first = lower_[begin];
    const bool usual = std::string_view("az019").find(first) != std::string_view::npos;
    const double start = usual ? 4 : IsDigit(first) ? 10 : 26;
    Add(begin, end, start * static_cast<double>(end - begin) * (step == 1 ? 1 : 2),
        LogOfCapitals(text_.substr(begin, end - begin)));
  }

  // Neighbours on a keyboard, straight or with turns.
  void AddWalks();
  // A year or a date.
  void AddDates();

  // Units that begin here and occur at least twice (a character: three times), without those that
  // repeat a shorter one: a handful are left.
  void AddRepeats() {
    const size_t n = lower_.size();
    for (size_t i = 0; i < n; ++i) {
      std::vector<std::pair<size_t, size_t>> found;  // unit, how much it covers
      for (size_t unit = 1; i + 2 * unit <= n; ++unit) {
        size_t times = 1;
        while (i + (times + 1) * unit <= n &&
               lower_.compare(i + times * unit, unit, lower_, i, unit) == 0) {
          ++times;
        }
        if (times < (unit == 1 ? 3u : 2u)) continue;
        auto again = [&](const auto& shorter) {
          return unit % shorter.first == 0 && unit <= shorter.second;
        };
        if (std::ranges::any_of(found, again)) continue;
        found.emplace_back(unit, times * unit);
        const double once = Reading(text_.substr(i, unit), known_).Log10();
        for (size_t k = 2; k <= times; ++k) Add(i, i + k * unit, static_cast<double>(k), once);
      }
    }
  }

  // best[end][k]: the text up to `end` in k pieces, characters that nothing explains between them
  // being one piece.
  double Cheapest() const {
    constexpr double kNever = std::numeric_limits<double>::infinity();
    const size_t n = text_.size();
    std::vector<std::array<double, kMaxPieces + 1>> best(n + 1);
    for (auto& row : best) row.fill(kNever);
    best[0][0] = 0;
    for (size_t end = 1; end <= n; ++end) {
      auto take = [&](size_t begin, double log10) {
        for (size_t k = 0; k < kMaxPieces; ++k) {
          best[end][k + 1] = std::min(best[end][k + 1], best[begin][k] + log10);
        }
      };
      for (const Piece& piece : pieces_) {
        if (piece.end == end) take(piece.begin, piece.log10);
      }
      for (size_t begin = 0; begin < end; ++begin) take(begin, static_cast<double>(end - begin));
    }
    double out = n == 0 ? 0 : kNever, orders_log10 = 0;
    for (size_t k = 1; k <= kMaxPieces; ++k) {
      orders_log10 += std::log10(static_cast<double>(k));
      out = std::min(out, best[n][k] + orders_log10);
    }
    return out;
  }

  std::string_view text_;
  std::string lower_;
  const std::vector<std::string>& known_;
  std::vector<Piece> pieces_;
};

// The four rows of a keyboard, each a third to a half of a key right of the one above; the same
// keys with Shift below them.
struct Keyboard {
  std::array<std::string_view, 4> rows, shifted;
};
constexpr std::array<Keyboard, 3> kKeyboards = {
    {{{"`1234567890-=", " qwertyuiop[]", " asdfghjkl;'", " zxcvbnm,./"},
      {"~!@#$%^&*()_+", " QWERTYUIOP{}", " ASDFGHJKL:\"", " ZXCVBNM<>?"}},
     {{"^1234567890", " qwertzuiop", " asdfghjkl", " yxcvbnm,.-"},
      {"~!\"#$%&/()=", " QWERTZUIOP", " ASDFGHJKL", " YXCVBNM;:_"}},
     {{" 1234567890", " azertyuiop", " qsdfghjklm", " wxcvbn,;:!"},
      {" &#\"'(-_@) ", " AZERTYUIOP", " QSDFGHJKLM", " WXCVBN?./"}}}};

struct Key {
  int row, column;
  bool operator==(const Key&) const = default;
};

std::optional<Key> KeyOf(const Keyboard& keyboard, char c) {
  if (c == ' ') return {};
  for (const auto& rows : {keyboard.rows, keyboard.shifted}) {
    for (size_t row = 0; row < rows.size(); ++row) {
      if (size_t at = rows[row].find(c); at != std::string_view::npos) {
        return Key{static_cast<int>(row), static_cast<int>(at)};
      }
    }
  }
  return {};
}

// The step from one key to the other; none where they do not touch.
std::optional<Key> StepOf(const Keyboard& keyboard, char from, char to) {
  auto a = KeyOf(keyboard, from), b = KeyOf(keyboard, to);
  if (!a || !b) return {};
  const Key step{b->row - a->row, b->column - a->column};
  const bool touch = step == Key{0, 1} || step == Key{0, -1} || step == Key{1, 0} ||
                     step == Key{-1, 0} || step == Key{1, -1} || step == Key{-1, 1};
  return touch ? std::optional(step) : std::nullopt;
}

void Reading::AddWalks() {
  constexpr double kKeys = 47;
  const double turn_log10 = std::log10(5.0);
  for (const Keyboard& keyboard : kKeyboards) {
    for (size_t i = 0; i < text_.size(); ++i) {
      std::optional<Key> last;
      int turns = 0;
      for (size_t at = i + 1; at < text_.size(); ++at) {
        auto step = StepOf(keyboard, text_[at - 1], text_[at]);
        if (!step) break;
        if (last && *step != *last) ++turns;
        last = step;
        const size_t length = at + 1 - i;
        if (length < 3) continue;
        Add(i, at + 1, kKeys * static_cast<double>(length), turns * turn_log10);
      }
    }
  }
}

bool IsYear(int year) { return year >= 1900 && year < 2050; }

bool IsDay(int one, int other) {
  return one >= 1 && other >= 1 && std::min(one, other) <= 12 && std::max(one, other) <= 31;
}

// Of at most four digits; none when it is anything else.
std::optional<int> NumberOf(std::string_view text) {
  if (text.empty() || text.size() > 4 || !std::ranges::all_of(text, IsDigit)) return {};
  int out = 0;
  for (char c : text) out = out * 10 + (c - '0');
  return out;
}

// Day, month and year in any of the usual orders; a year of two digits says its last two.
bool IsDate(std::string_view first, std::string_view second, std::string_view third) {
  auto a = NumberOf(first), b = NumberOf(second), c = NumberOf(third);
  if (!a || !b || !c) return false;
  auto is_year = [](std::string_view text, int value) {
    return text.size() == 2 || (text.size() == 4 && IsYear(value));
  };
  return (is_year(third, *c) && IsDay(*a, *b)) || (is_year(first, *a) && IsDay(*b, *c));
}

constexpr double kDays = 366 * 2;  // and whether the day or the month comes first

// How many guesses `text` is as a date or a part of one; 0: it is none.
double DateGuesses(std::string_view text) {
  const size_t n = text.size();
  if (std::ranges::all_of(text, IsDigit)) {
    if (n == 4 && IsYear(*NumberOf(text))) return kYears;
    auto at = [&](size_t begin, size_t size) { return text.substr(begin, size); };
    if (n == 4 && IsDay(*NumberOf(at(0, 2)), *NumberOf(at(2, 2)))) return kDays;
    const bool six = n == 6 && IsDate(at(0, 2), at(2, 2), at(4, 2));
    const bool eight =
        n == 8 && (IsDate(at(0, 2), at(2, 2), at(4, 4)) || IsDate(at(0, 4), at(4, 2), at(6, 2)));
    return six || eight ? kDays * kYears : 0;
  }
  const size_t first = text.find_first_of(" .-/_");
  const size_t second = first < n ? text.find(text[first], first + 1) : n;
  if (second >= n) return 0;
  constexpr double kBetween = 4;
  const bool date = IsDate(text.substr(0, first), text.substr(first + 1, second - first - 1),
                           text.substr(second + 1));
  return date ? kDays * kYears * kBetween : 0;
}

void Reading::AddDates() {
  constexpr size_t kShortest = 4, kLongest = 10;
  for (size_t i = 0; i < text_.size(); ++i) {
    for (size_t n = kShortest; n <= kLongest && i + n <= text_.size(); ++n) {
      const double guesses = DateGuesses(text_.substr(i, n));
      if (guesses > 0) Add(i, i + n, guesses);
    }
  }
}

// A letter of any script: names are not of ASCII alone.
bool IsLetter(char c) { return IsLower(c) || IsDigit(c) || static_cast<unsigned char>(c) >= 0x80; }

// The known texts as a whole, their words, and those joined.
std::vector<std::string> PartsOf(const std::vector<std::string_view>& known) {
  std::vector<std::string> out;
  for (std::string_view one : known) {
    const std::string whole = LowerText(one);
    std::string together, word;
    for (char c : whole + " ") {
      if (IsLetter(c)) {
        word += c;
        continue;
      }
      out.push_back(word);
      together += word;
      word.clear();
    }
    out.push_back(whole);
    out.push_back(together);
  }
  std::erase_if(out, [](const std::string& part) { return part.size() < kShortestWord; });
  return out;
}

}  // namespace

double Log10Guesses(std::string_view password, const std::vector<std::string_view>& known) {
  std::vector<std::string> parts = PartsOf(known);
  for (size_t i = 0, n = parts.size(); i < n; ++i) {
    if (std::string part = WithoutMarks(parts[i]); part != parts[i]) parts.push_back(part);
  }
  const std::string text(password.substr(0, kLongestLookedAt)), plain = WithoutMarks(text);
  double out = Reading(text, parts).Log10();
  if (plain != text) out = std::min(out, Reading(plain, parts).Log10());
  // A known phrase, whatever is between its words.
  std::string joined = LowerText(plain);
  std::erase_if(joined, [](char c) { return !IsLower(c); });
  if (const int rank = UndressedRank(Undressed(joined)); rank > 0 && joined.size() < plain.size())
    out = std::min(out, std::log10(rank) + static_cast<double>(plain.size() - joined.size()));
  return out;
}

}  // namespace enamel::server::auth
