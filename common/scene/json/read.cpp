#include "common/scene/json/read.h"

#include <algorithm>
#include <boost/json.hpp>
#include <cmath>
#include <limits>

#include "common/scene/json/kinds.h"

namespace enamel::scene {
namespace {

namespace json = boost::json;

constexpr size_t kMaxText = size_t{1} << 20;
// Deeper than any document of ours.
constexpr size_t kMaxDepth = 16;

size_t CountMembers(const json::value& v) {
  size_t n = 0;
  if (v.is_object()) {
    for (const auto& member : v.get_object()) n += 1 + CountMembers(member.value());
  } else if (v.is_array()) {
    for (const auto& item : v.get_array()) n += CountMembers(item);
  }
  return n;
}

// In valid JSON there is one colon outside strings per member written. Boost.JSON keeps the last of
// two members of one name without an error, and another reader may keep the first. So the members
// kept are compared with the members written.
size_t CountColons(std::string_view text) {
  size_t n = 0;
  bool in_string = false;
  for (size_t i = 0; i < text.size(); ++i) {
    // An escaped quote ends no string.
    if (in_string && text[i] == '\\') {
      ++i;
    } else if (text[i] == '"') {
      in_string = !in_string;
    } else if (!in_string && text[i] == ':') {
      ++n;
    }
  }
  return n;
}

std::string Describe(const json::value& v) {
  std::string text = json::serialize(v);
  // A refusal quotes what it found, and must not be as long as a document.
  if (text.size() <= 60) return text;
  size_t end = 57;
  // Not within a character: a byte 10xxxxxx continues the character that an earlier byte began (RFC
  // 3629).
  while (end > 0 && (static_cast<uint8_t>(text[end]) & 0xc0) == 0x80) --end;
  return text.substr(0, end) + "...";
}

std::string RangeText(double lo, double hi) {
  return json::serialize(json::value(lo)) + " to " + json::serialize(json::value(hi));
}

constexpr size_t kMaxName = 64;
constexpr char kPlain[] = "lower-case letters, digits, '-' and '_'";
bool IsPlain(std::string_view text) {
  return std::ranges::all_of(text, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
  });
}

}  // namespace

Result<json::value> ParseBounded(std::string_view text) {
  if (text.size() > kMaxText) {
    return Status(Code::kTooLarge, "expected a document of at most 1 MiB, found " +
                                       std::to_string(text.size()) + " bytes");
  }
  json::parse_options options;
  options.max_depth = kMaxDepth;
  json::stream_parser parser({}, options);
  json::error_code error;
  // Not parse(): this says at which byte it stopped.
  size_t used = parser.write_some(text.data(), text.size(), error);
  if (!error && used < text.size()) {
    bool blank = std::all_of(text.begin() + static_cast<ptrdiff_t>(used), text.end(), [](char c) {
      return c == ' ' || c == '\n' || c == '\r' || c == '\t';
    });
    if (!blank) error = json::error::extra_data;
  }
  if (!error) parser.finish(error);
  if (error) {
    return Status(Code::kInvalidInput,
                  "not valid JSON at byte " + std::to_string(used) + ": " + error.message());
  }
  json::value value = parser.release();
  if (CountMembers(value) != CountColons(text)) {
    return Status(Code::kInvalidInput, "a member appears twice in one object: keep one of them");
  }
  return value;
}

ObjectReader::ObjectReader(const json::value& value, std::string path, Status& status)
    : path_(std::move(path)), status_(&status) {
  if (value.is_object()) {
    object_ = &value.get_object();
  } else if (status_->ok()) {
    *status_ = Status(Code::kInvalidInput,
                      "expected an object at '" + path_ + "', found " + Describe(value), path_);
  }
}

void ObjectReader::Refuse(std::string_view name, const std::string& expected,
                          const std::string& found) {
  if (!status_->ok()) return;
  *status_ = Status(Code::kInvalidInput,
                    PathOf(name) + ": expected " + expected + ", found " + found, PathOf(name));
}

const json::value* ObjectReader::Take(std::string_view name) {
  if (object_ == nullptr || !status_->ok()) return nullptr;
  // Also where it is missing: it was asked for, so Finish does not blame another for it.
  taken_.emplace(name);
  const json::value* value = object_->if_contains(name);
  if (value == nullptr) Refuse(name, "this member", "none");
  return value;
}

bool ObjectReader::Has(std::string_view name) const {
  return object_ != nullptr && object_->contains(name);
}

std::vector<std::string> ObjectReader::Names() const {
  std::vector<std::string> names;
  if (object_ == nullptr) return names;
  for (const auto& member : *object_) names.emplace_back(member.key());
  return names;
}

int64_t ObjectReader::Int(std::string_view name, int64_t lo, int64_t hi) {
  const json::value* v = Take(name);
  if (v == nullptr) return lo;
  // 1.0 and 1e3 are no integers here: one value has one text.
  const int64_t* number = v->if_int64();
  if (number == nullptr || *number < lo || *number > hi) {
    Refuse(name, "an integer from " + std::to_string(lo) + " to " + std::to_string(hi),
           Describe(*v));
    return lo;
  }
  return *number;
}

double ObjectReader::Number(std::string_view name, double lo, double hi) {
  const json::value* v = Take(name);
  if (v == nullptr) return lo;
  json::error_code error;
  double number = v->is_number() ? v->to_number<double>(error) : std::nan("");
  if (error || !(number >= lo && number <= hi)) {
    Refuse(name, "a number from " + RangeText(lo, hi), Describe(*v));
    return lo;
  }
  return number;
}

bool ObjectReader::Bool(std::string_view name) {
  const json::value* v = Take(name);
  if (v == nullptr) return false;
  if (!v->is_bool()) Refuse(name, "true or false", Describe(*v));
  return v->is_bool() && v->get_bool();
}

std::string ObjectReader::Text(std::string_view name, size_t min_size, size_t max_size) {
  const json::value* v = Take(name);
  if (v == nullptr) return {};
  if (!v->is_string()) {
    Refuse(name, "text", Describe(*v));
    return {};
  }
  std::string text(v->get_string());
  if (text.size() < min_size || text.size() > max_size) {
    Refuse(name,
           "text of " + std::to_string(min_size) + " to " + std::to_string(max_size) + " bytes",
           std::to_string(text.size()) + " bytes");
    return {};
  }
  return text;
}

std::string ObjectReader::Name(std::string_view name) {
  std::string text = Text(name, 1, kMaxName);
  if (!IsPlain(text)) Refuse(name, kPlain, "\"" + text + "\"");
  return text;
}

std::vector<std::string> ObjectReader::NameList(std::string_view name, size_t max_count) {
  std::vector<std::string> out;
  const json::value* v = Take(name);
  if (v == nullptr) return out;
  bool good = v->is_array() && !v->get_array().empty() && v->get_array().size() <= max_count;
  for (size_t i = 0; good && i < v->get_array().size(); ++i) {
    const json::string* text = v->get_array()[i].if_string();
    good = text != nullptr && !text->empty() && text->size() <= kMaxName && IsPlain(*text);
    if (good) out.emplace_back(*text);
  }
  if (!good) {
    Refuse(name, "1 to " + std::to_string(max_count) + " names of " + kPlain, Describe(*v));
  }
  return out;
}

Sha256 ObjectReader::Hash(std::string_view name) {
  std::string text = Text(name, 64, 64);
  if (!status_->ok()) return {};
  Result<Sha256> hash = Sha256::FromHex(text);
  if (!hash.ok()) {
    Refuse(name, "64 hexadecimal digits", "\"" + text + "\"");
    return {};
  }
  return *hash;
}

std::vector<int32_t> ObjectReader::Ints(std::string_view name, size_t size, int32_t lo,
                                        int32_t hi) {
  std::vector<int32_t> out(size, lo);
  const json::value* v = Take(name);
  if (v == nullptr) return out;
  bool good = v->is_array() && v->get_array().size() == size;
  for (size_t i = 0; good && i < size; ++i) {
    const int64_t* number = v->get_array()[i].if_int64();
    good = number != nullptr && *number >= lo && *number <= hi;
    if (good) out[i] = static_cast<int32_t>(*number);
  }
  if (!good) {
    Refuse(
        name,
        std::to_string(size) + " integers from " + std::to_string(lo) + " to " + std::to_string(hi),
        Describe(*v));
  }
  return out;
}

std::vector<std::vector<double>> ObjectReader::Rows(std::string_view name, size_t size,
                                                    size_t max_rows) {
  std::vector<std::vector<double>> out;
  const json::value* v = Take(name);
  if (v == nullptr) return out;
  bool good = v->is_array() && !v->get_array().empty() && v->get_array().size() <= max_rows;
  for (size_t r = 0; good && r < v->get_array().size(); ++r) {
    const json::value& row = v->get_array()[r];
    good = row.is_array() && row.get_array().size() == size;
    out.emplace_back(size);
    for (size_t i = 0; good && i < size; ++i) {
      json::error_code error;
      const json::value& item = row.get_array()[i];
      out.back()[i] = item.is_number() ? item.to_number<double>(error) : std::nan("");
      good = !error && std::isfinite(out.back()[i]);
    }
  }
  if (good) return out;
  Refuse(name, "1 to " + std::to_string(max_rows) + " rows of " + std::to_string(size) + " numbers",
         Describe(*v));
  return {};
}

ObjectReader ObjectReader::Object(std::string_view name) {
  // An empty object in its place. The refusal is noted, so nothing read from this one is believed.
  static const json::value kNone = json::object();
  const json::value* v = Take(name);
  return ObjectReader(v == nullptr ? kNone : *v, PathOf(name), *status_);
}

std::vector<ObjectReader> ObjectReader::Objects(std::string_view name, size_t min_count,
                                                size_t max_count) {
  std::vector<ObjectReader> out;
  const json::value* v = Take(name);
  if (v == nullptr) return out;
  if (!v->is_array() || v->get_array().size() < min_count || v->get_array().size() > max_count) {
    Refuse(name,
           std::to_string(min_count) + " to " + std::to_string(max_count) + " objects in an array",
           Describe(*v));
    return out;
  }
  for (size_t i = 0; i < v->get_array().size(); ++i) {
    out.emplace_back(v->get_array()[i], PathOf(name) + "/" + std::to_string(i), *status_);
  }
  return out;
}

void ObjectReader::Format(std::string_view kind) {
  auto refuse = [&](std::string_view member, const std::string& found) {
    *status_ = Status(Code::kVersion,
                      PathOf(member) + ": expected a document that begins with \"" +
                          std::string(kind) + "\": " + std::to_string(kFormat) + ", found " + found,
                      PathOf(member));
  };
  if (status_->ok() && Has("format") && !Has(kind)) {
    return refuse("format", "one made by an earlier Enamel: make it again with this one");
  }
  // Any larger number passes here: a newer format is no mistake, and gets its own refusal.
  const int64_t found = Int(kind, kFormat, std::numeric_limits<int32_t>::max());
  if (status_->ok() && found > kFormat) {
    refuse(kind, std::to_string(found) + ": use a newer program");
  }
}

void ObjectReader::Finish() {
  if (object_ == nullptr || !status_->ok()) return;
  for (const auto& member : *object_) {
    if (taken_.count(std::string_view(member.key())) == 0) {
      Refuse(member.key(), "no such member (a misspelt name is not ignored)", "it");
      return;
    }
  }
}

}  // namespace enamel::scene
