#include "server/http/json_body.h"

#include <algorithm>
#include <boost/json/basic_parser_impl.hpp>
#include <charconv>
#include <cmath>
#include <set>

#include "server/http/error_response.h"

namespace enamel::server::http {
namespace json = boost::json;

namespace {

// Stops at a member that an object has a second time: boost::json::parse keeps one of them in
// silence, and somebody who looked at the body before may have looked at the other.
class RepeatFinder {
 public:
  static constexpr size_t max_object_size = SIZE_MAX;
  static constexpr size_t max_array_size = SIZE_MAX;
  static constexpr size_t max_key_size = SIZE_MAX;
  static constexpr size_t max_string_size = SIZE_MAX;

  const std::optional<std::string>& repeated() const { return repeated_; }

  bool on_document_begin(json::error_code&) { return true; }
  bool on_document_end(json::error_code&) { return true; }
  bool on_object_begin(json::error_code&) {
    open_.emplace_back();
    return true;
  }
  bool on_object_end(size_t, json::error_code&) {
    open_.pop_back();
    return true;
  }
  bool on_array_begin(json::error_code&) { return true; }
  bool on_array_end(size_t, json::error_code&) { return true; }
  bool on_key_part(json::string_view part, size_t, json::error_code&) {
    key_ += std::string_view(part.data(), part.size());
    return true;
  }
  bool on_key(json::string_view part, size_t size, json::error_code& error) {
    on_key_part(part, size, error);
    std::string key = std::exchange(key_, {});
    if (open_.back().insert(key).second) return true;
    repeated_ = std::move(key);
    error = json::error::syntax;
    return false;
  }
  bool on_string_part(json::string_view, size_t, json::error_code&) { return true; }
  bool on_string(json::string_view, size_t, json::error_code&) { return true; }
  bool on_number_part(json::string_view, json::error_code&) { return true; }
  bool on_int64(int64_t, json::string_view, json::error_code&) { return true; }
  bool on_uint64(uint64_t, json::string_view, json::error_code&) { return true; }
  bool on_double(double, json::string_view, json::error_code&) { return true; }
  bool on_bool(bool, json::error_code&) { return true; }
  bool on_null(json::error_code&) { return true; }
  bool on_comment_part(json::string_view, json::error_code&) { return true; }
  bool on_comment(json::string_view, json::error_code&) { return true; }

 private:
  std::vector<std::set<std::string>> open_;  // members so far of every object that is not ended
  std::string key_;
  std::optional<std::string> repeated_;
};

// As much memory again as the body, which is bounded.
std::optional<std::string> RepeatedMember(const std::string& body,
                                          const json::parse_options& options) {
  json::basic_parser<RepeatFinder> parser(options);
  json::error_code ignored;
  parser.write_some(false, body.data(), body.size(), ignored);
  return parser.handler().repeated();
}

Result<json::object> ParseObject(const Request& request, size_t max_depth = kPlainDepth) {
  json::parse_options options;
  options.max_depth = max_depth;
  json::error_code error;
  json::value value = json::parse(request.body, error, {}, options);
  if (error || !value.is_object()) {
    return Status{Code::kInvalidInput, "expected a JSON object as body", "body"};
  }
  if (std::optional<std::string> twice = RepeatedMember(request.body, options)) {
    return Status{Code::kInvalidInput, "expected every member once, found this one twice", *twice};
  }
  return std::move(value.get_object());
}

bool IsReadable(std::string_view text) {
  return std::ranges::none_of(
      text, [](unsigned char c) { return (c < 0x20 && c != '\n' && c != '\t') || c == 0x7f; });
}

// A number as people write it: boost::json writes 1.009E2.
std::string Decimal(double value) {
  char text[32];
  const auto end = std::to_chars(text, text + sizeof text, value).ptr;
  return {text, end};
}

// The unexpected value, cut short.
std::string Shown(const json::value* found) {
  constexpr size_t kMost = 80;
  if (!found) return "none";
  // Before quoting it: a refusal must not be as long as the refused value.
  if (found->is_string() && found->get_string().size() > kMost) {
    return "text of " + std::to_string(found->get_string().size()) + " bytes";
  }
  if (found->is_array()) return "a list of " + std::to_string(found->get_array().size());
  if (found->is_object()) return "an object";
  return found->is_double() ? Decimal(found->get_double()) : json::serialize(*found);
}

// Three numbers, each at most `limit` from 0.
std::optional<std::array<double, 3>> PointOf(const json::value& value, double limit) {
  std::array<double, 3> out{};
  if (!value.is_array() || value.get_array().size() != out.size()) return std::nullopt;
  for (size_t axis = 0; axis < out.size(); ++axis) {
    const json::value& entry = value.get_array()[axis];
    if (!entry.is_number()) return std::nullopt;
    out[axis] = entry.to_number<double>();
    if (!(std::abs(out[axis]) <= limit)) return std::nullopt;
  }
  return out;
}

std::optional<Uuid> IdOf(const json::value& value) {
  if (!value.is_string()) return std::nullopt;
  Result<Uuid> id = Uuid::Parse(std::string_view(value.get_string()));
  return id.ok() ? std::optional(*id) : std::nullopt;
}

}  // namespace

Response JsonResponse(const json::object& object, int status) {
  Response response;
  response.status = status;
  response.content_type = "application/json";
  response.body = json::serialize(object);
  return response;
}

Result<json::object> TextMembers(const Request& request,
                                 std::initializer_list<TextMember> members) {
  // What fits has at most six bytes for each (\u0061). Larger ones are not even parsed: that would
  // hold up the threads that read and answer everything else.
  size_t most = 1024;
  for (const TextMember& member : members) most += 6 * member.max_length;
  if (request.body.size() > most) {
    return Status{Code::kTooLarge, "expected a body of at most " + std::to_string(most) + " bytes",
                  "body"};
  }
  Result<json::object> parsed = ParseObject(request);
  ENAMEL_RETURN_IF_ERROR(parsed.status());
  json::object& object = *parsed;
  for (const TextMember& member : members) {
    const json::value* found = object.if_contains(member.name);
    if (!found || !found->is_string() || found->get_string().empty() ||
        found->get_string().size() > member.max_length) {
      return Status{Code::kInvalidInput,
                    "expected " + std::string(member.name) + " as text of 1 to " +
                        std::to_string(member.max_length) + " bytes",
                    std::string(member.name)};
    }
  }
  for (const auto& entry : object) {
    bool known = std::any_of(members.begin(), members.end(),
                             [&](const TextMember& member) { return member.name == entry.key(); });
    if (!known) {
      return Status{Code::kInvalidInput, "expected no member of this name",
                    std::string(entry.key())};
    }
  }
  return parsed;
}

BodyReader::BodyReader(const Request& request, size_t max_depth) {
  Result<json::object> parsed = ParseObject(request, max_depth);
  if (parsed.ok()) {
    object_ = std::move(*parsed);
  } else {
    status_ = parsed.status();
  }
}

void BodyReader::Refuse(std::string_view name, const std::string& expected) {
  // Reports the first fault: later ones are often its consequences.
  if (!status_.ok()) return;
  status_ = Status{Code::kInvalidInput,
                   "expected " + std::string(name) + " as " + expected + ", found " +
                       Shown(object_.if_contains(name)),
                   std::string(name)};
}

const json::value* BodyReader::Find(std::string_view name) {
  // Finish compares the body's members with the requested ones. So a misspelt optional member is
  // refused, and does not count as left out.
  asked_.emplace_back(name);
  return object_.if_contains(name);
}

const json::value* BodyReader::Need(std::string_view name, const std::string& expected) {
  const json::value* found = Find(name);
  if (!found) Refuse(name, expected);
  return found;
}

std::string BodyReader::Text(std::string_view name, size_t at_least, size_t at_most) {
  std::string expected = "text of " + std::to_string(at_least) + " to " + std::to_string(at_most) +
                         " bytes without control characters";
  const json::value* found = Need(name, expected);
  if (!found) return {};
  bool fits = found->is_string() && found->get_string().size() >= at_least &&
              found->get_string().size() <= at_most && IsReadable(found->get_string());
  if (fits) return std::string(found->get_string());
  Refuse(name, expected);
  return {};
}

int64_t BodyReader::Integer(std::string_view name, int64_t at_least, int64_t at_most) {
  std::string expected =
      "a whole number of " + std::to_string(at_least) + " to " + std::to_string(at_most);
  const json::value* found = Need(name, expected);
  if (!found) return at_least;
  json::error_code error;
  // Also 3.0, which is what JavaScript may write for 3; 3.5 is an error.
  auto number = found->is_number() ? found->to_number<int64_t>(error) : 0;
  if (found->is_number() && !error && number >= at_least && number <= at_most) return number;
  Refuse(name, expected);
  return at_least;
}

int64_t BodyReader::Integer(std::string_view name, int64_t at_least, int64_t at_most,
                            int64_t otherwise) {
  if (object_.if_contains(name)) return Integer(name, at_least, at_most);
  return otherwise;
}

double BodyReader::Number(std::string_view name, double at_least, double at_most) {
  std::string expected = "a number of " + Decimal(at_least) + " to " + Decimal(at_most);
  const json::value* found = Need(name, expected);
  if (!found) return at_least;
  double number = found->is_number() ? found->to_number<double>() : at_least - 1;
  if (number >= at_least && number <= at_most) return number;
  Refuse(name, expected);
  return at_least;
}

bool BodyReader::Flag(std::string_view name) {
  (void)Need(name, "true or false");
  return Flag(name, false);
}

bool BodyReader::Flag(std::string_view name, bool otherwise) {
  const json::value* found = Find(name);
  if (!found) return otherwise;
  if (found->is_bool()) return found->get_bool();
  Refuse(name, "true or false");
  return otherwise;
}

std::optional<Uuid> BodyReader::MaybeId(std::string_view name) {
  const json::value* found = Find(name);
  if (!found || found->is_null()) return std::nullopt;
  std::optional<Uuid> id = IdOf(*found);
  if (!id) Refuse(name, "an id (UUID text) or null");
  return id;
}

std::vector<Uuid> BodyReader::Ids(std::string_view name, size_t at_most) {
  std::vector<Uuid> out;
  const json::value* found = Find(name);
  if (!found) return out;
  std::string expected = "a list of at most " + std::to_string(at_most) + " different ids";
  if (!found->is_array() || found->get_array().size() > at_most) {
    Refuse(name, expected);
    return out;
  }
  for (const json::value& entry : found->get_array()) {
    std::optional<Uuid> id = IdOf(entry);
    if (!id || std::ranges::find(out, *id) != out.end()) {
      Refuse(name, expected);
      return out;
    }
    out.push_back(*id);
  }
  return out;
}

std::string BodyReader::Document(std::string_view name) {
  const json::value* value = Need(name, "an object");
  if (value != nullptr && value->is_object()) return json::serialize(*value);
  if (value != nullptr) Refuse(name, "an object");
  return "{}";
}

std::optional<std::array<int32_t, 3>> BodyReader::MaybePoint(std::string_view name) {
  // One metre from the scene's origin: no tooth is that large, and an int32_t holds it in
  // micrometres.
  constexpr int64_t kFarUm = 1'000'000;
  const json::value* found = Find(name);
  if (!found || found->is_null()) return std::nullopt;
  std::array<int32_t, 3> out{};
  bool fits = found->is_array() && found->get_array().size() == out.size();
  for (size_t axis = 0; fits && axis < out.size(); ++axis) {
    const json::value& entry = found->get_array()[axis];
    json::error_code error;
    auto number = entry.is_number() ? entry.to_number<int64_t>(error) : kFarUm + 1;
    fits = !error && number >= -kFarUm && number <= kFarUm;
    out[axis] = fits ? static_cast<int32_t>(number) : 0;
  }
  if (fits) return out;
  Refuse(name, "three whole numbers of -1000000 to 1000000, or null");
  return std::nullopt;
}

std::vector<BodyReader::Curve> BodyReader::Curves(std::string_view name, size_t at_most) {
  constexpr double kFar = 10'000;
  std::vector<Curve> out;
  const json::value* found = Find(name);
  if (!found) return out;
  bool fits = found->is_array() && found->get_array().size() <= at_most;
  for (size_t i = 0; fits && i < found->get_array().size(); ++i) {
    const json::value& points = found->get_array()[i];
    Curve& curve = out.emplace_back();
    fits = points.is_array();
    for (size_t k = 0; fits && k < points.get_array().size(); ++k) {
      const auto point = PointOf(points.get_array()[k], kFar);
      fits = point.has_value();
      if (fits) curve.push_back(*point);
    }
  }
  if (fits) return out;
  Refuse(name, "at most " + std::to_string(at_most) +
                   " lists of points of three numbers of -10000 to 10000");
  return {};
}

Status BodyReader::Finish() {
  for (const auto& entry : object_) {
    if (!status_.ok()) break;
    if (std::ranges::find(asked_, entry.key()) != asked_.end()) continue;
    status_ =
        Status{Code::kInvalidInput, "expected no member of this name", std::string(entry.key())};
  }
  return status_;
}

bool IsJson(const Request& request) {
  std::string type(request.Header("content-type"));
  type = type.substr(0, type.find(';'));
  type.erase(std::remove(type.begin(), type.end(), ' '), type.end());
  return type == "application/json";
}

Response NotJson() {
  return ErrorResponse(415, "unsupported_media_type", "expected Content-Type: application/json",
                       "content-type");
}

}  // namespace enamel::server::http
