#include "server/storage/upkeep/mentions.h"

#include <algorithm>
#include <set>

#include "server/storage/engine/query.h"
#include "server/training/names.h"

namespace enamel::server {
namespace {

// The id of the place, then texts in it.
struct Typed {
  const char* kind;
  bool has_page;
  const char* sql;
};
constexpr Typed kTyped[] = {
    {"attempt", true, "SELECT attempt, text FROM annotations WHERE tenant = ?1"},
    {"saved_text", false, "SELECT id, text FROM saved_texts WHERE tenant = ?1"},
    {"attempt", true, "SELECT attempt, text, answer FROM appeals WHERE tenant = ?1"},
    {"attempt", true,
     "SELECT w.attempt, m.criteria FROM marks m JOIN marking_works w ON w.tenant = m.tenant AND "
     "w.id = m.work WHERE m.tenant = ?1"},
    {"attempt", true,
     "SELECT id, override_reason FROM attempts WHERE tenant = ?1 AND override_reason <> ''"},
    {"reference", true, "SELECT attempt, dentist FROM reference_cuts WHERE tenant = ?1"},
    {"exercise", true, "SELECT id, title FROM exercises WHERE tenant = ?1"},
    {"exercise", true, "SELECT exercise, reason FROM rubrics WHERE tenant = ?1"},
    {"cohort", true, "SELECT id, name FROM cohorts WHERE tenant = ?1"},
    {"station", false, "SELECT id, name FROM stations WHERE tenant = ?1"},
    {"scene", false, "SELECT volume, title FROM scenes WHERE tenant = ?1"},
    {"profile", false, "SELECT content, title FROM profiles WHERE tenant = ?1"},
    {"device", false, "SELECT '', title FROM listed_devices WHERE tenant = ?1"},
    {"batch", false, "SELECT id, title FROM job_batches WHERE tenant = ?1"},
};

bool IsInWord(char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9'); }

// Both as SearchName writes them.
bool HasWord(const std::string& text, const std::string& word) {
  for (size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) {
    const size_t end = at + word.size();
    const bool begins = at == 0 || !IsInWord(text[at - 1]) || !IsInWord(text[at]);
    const bool ends = end == text.size() || !IsInWord(text[end]) || !IsInWord(text[end - 1]);
    if (begins && ends) return true;
  }
  return false;
}

void AddPlace(Mentions& mentions, std::string place) {
  auto& places = mentions.places;
  if (places.size() >= Mentions::kMaxPlaces) return;
  if (std::ranges::find(places, place) == places.end()) places.push_back(std::move(place));
}

}  // namespace

Result<std::vector<Mentions>> MentionsOf(Db& db, const Person& person) {
  std::set<std::string> words{SearchName(person.display_name), SearchName(person.login)};
  words.erase("");
  std::vector<Mentions> out;
  for (const Typed& typed : kTyped) {
    Mentions found{typed.kind, 0, {}};
    Query q(db, typed.sql);
    while (q.Next()) {
      bool here = false;
      for (int column = 1; column < q.columns() && !here; ++column) {
        const std::string text = SearchName(q.Text(column));
        here = std::ranges::any_of(words, [&](const auto& word) { return HasWord(text, word); });
      }
      if (!here) continue;
      ++found.count;
      if (typed.has_page) AddPlace(found, q.Id(0).Text());
    }
    ENAMEL_RETURN_IF_ERROR(q.status());
    if (found.count == 0) continue;
    const auto same = std::ranges::find(out, found.kind, &Mentions::kind);
    if (same == out.end()) {
      out.push_back(std::move(found));
      continue;
    }
    same->count += found.count;
    for (std::string& place : found.places) AddPlace(*same, std::move(place));
  }
  return out;
}

}  // namespace enamel::server
