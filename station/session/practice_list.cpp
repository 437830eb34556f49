#include "station/session/practice_list.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <boost/json.hpp>
#include <optional>
#include <set>

#include "common/base/file.h"

namespace enamel::station {
namespace {

namespace fs = std::filesystem;
namespace json = boost::json;
using Documents = std::vector<PracticeList::Document>;

constexpr char kMark[] = "enamel_practice";
constexpr int kFormat = 1;
// More than a school's course has. The file has two lists, and JSON writes a byte of a name with at
// most six; a longer one is not read.
constexpr size_t kMaxDocuments = 500, kMaxName = 200;
constexpr size_t kMaxFileBytes = 2 * kMaxDocuments * (6 * kMaxName + 100) + 1000;

fs::path PracticeFile(const fs::path& data) { return data / "practice.json"; }

bool CanBeKept(const std::string& name) { return !name.empty() && name.size() <= kMaxName; }

bool Has(const Documents& all, const std::string& name) {
  return std::ranges::find(all, name, &PracticeList::Document::first) != all.end();
}

// `before` goes behind, without the names that are there or in `out_of_it`.
void AddOlder(Documents& to, const Documents& before, const std::set<std::string>& out_of_it) {
  for (const auto& document : before) {
    if (!Has(to, document.first) && !out_of_it.contains(document.first)) to.push_back(document);
  }
  if (to.size() > kMaxDocuments) to.resize(kMaxDocuments);
}

json::object ToJson(const Documents& documents) {
  json::object out;
  for (const auto& [name, hash] : documents) out[name] = hash.Hex();
  return out;
}

std::string ToJson(const PracticeList& list) {
  return json::serialize(json::object{{kMark, kFormat},
                                      {"exercises", ToJson(list.exercises)},
                                      {"profiles", ToJson(list.profiles)}}) +
         "\n";
}

std::optional<Documents> FromJson(const json::object& file, const char* member) {
  const json::value* all = file.if_contains(member);
  if (all == nullptr || !all->is_object() || all->get_object().size() > kMaxDocuments) return {};
  Documents out;
  for (const auto& [name, value] : all->get_object()) {
    const json::string* text = value.if_string();
    if (text == nullptr || name.size() > kMaxName) return {};
    const auto hash = Sha256::FromHex(*text);
    if (!hash.ok()) return {};
    out.emplace_back(name, *hash);
  }
  return out;
}

std::optional<PracticeList> FromJson(const json::value& file) {
  if (!file.is_object()) return {};
  const json::value* format = file.get_object().if_contains(kMark);
  if (format == nullptr || *format != kFormat) return {};
  auto exercises = FromJson(file.get_object(), "exercises");
  auto profiles = FromJson(file.get_object(), "profiles");
  if (!exercises || !profiles) return {};
  return PracticeList{std::move(*exercises), std::move(*profiles)};
}

}  // namespace

PracticeList LoadPracticeList(const fs::path& data) {
  const fs::path file = PracticeFile(data);
  std::error_code error;
  if (!fs::exists(file, error)) return {};
  const auto bytes = ReadFile(file, kMaxFileBytes);
  // The parser's own bound on nesting is 32.
  const json::value read = bytes.ok() ? json::parse(AsText(*bytes), error) : json::value();
  if (auto list = FromJson(read)) return std::move(*list);
  spdlog::warn(
      "{}: no list of practice exercises, so none is offered without the server until "
      "somebody signs in with it: {}",
      file.string(),
      !bytes.ok() ? bytes.status().message()
      : error     ? error.message()
                  : "expected members 'exercises' and 'profiles', each from names to SHA-256");
  return {};
}

void KeepPracticeList(const fs::path& data, const Catalogue& described, int64_t now_unix_ms) {
  const PracticeList before = LoadPracticeList(data);
  // An exam's exercise may be listed for practice, too.
  std::set<std::string> not_for_practice;
  for (const Catalogue::Exercise& e : described.exercises) {
    if (e.exam || !e.facts || e.facts->graded || e.opens_unix_ms > now_unix_ms) {
      not_for_practice.insert(e.name);
    }
  }
  PracticeList list;
  for (const Catalogue::Exercise& e : described.exercises) {
    const bool may = CanBeKept(e.name) && !not_for_practice.contains(e.name);
    if (may && !Has(list.exercises, e.name)) list.exercises.emplace_back(e.name, e.exercise);
  }
  for (const Catalogue::Profile& p : described.profiles) {
    if (CanBeKept(p.name) && !Has(list.profiles, p.name)) {
      list.profiles.emplace_back(p.name, p.profile);
    }
  }
  AddOlder(list.exercises, before.exercises, not_for_practice);
  AddOlder(list.profiles, before.profiles, {});
  if (list == before) return;
  if (Status kept = WriteFileDurably(PracticeFile(data), AsBytes(ToJson(list))); !kept.ok()) {
    spdlog::warn("the list of practice exercises could not be kept: {}", kept.message());
  }
}

}  // namespace enamel::station
