#include <boost/json.hpp>
#include <charconv>
#include <concepts>
#include <optional>

#include "common/scoring/score_members.h"

// Writes and reads the stored form of a score: schemas/score.md.
namespace enamel::scoring {
namespace stored {

namespace json = boost::json;

// To 12 significant digits: more than any metric means, and few enough that every reader of decimal
// text gives back the same double.
static double Rounded(double value) {
  char text[40];
  auto end = std::to_chars(text, text + sizeof text, value, std::chars_format::general, 12).ptr;
  double out = value;
  std::from_chars(text, end, out);
  return out;
}

class Writer {
 public:
  static constexpr bool kWrites = true;
  json::object Take() { return std::move(out_); }

  template <typename T>
  requires std::integral<T> || std::same_as<T, std::string>
  void operator()(const char* name, const T& value) { out_[name] = value; }
  void operator()(const char* name, double value, double unit = 1) {
    out_[name] = Rounded(value / unit);
  }
  void operator()(const char* name, const dvec3& v, double unit = 1) {
    // Adding zero turns -0 into 0.
    out_[name] = json::array{Rounded(v.x / unit) + 0.0, Rounded(v.y / unit) + 0.0,
                             Rounded(v.z / unit) + 0.0};
  }
  void operator()(const char* name, const std::vector<double>& list, double unit, size_t) {
    json::array& out = (out_[name] = json::array()).get_array();
    for (double value : list) out.push_back(Rounded(value / unit));
  }
  void operator()(const char* name, const std::vector<std::string>& list, size_t) {
    out_[name] = json::value_from(list);
  }
  template <typename T>
  void Enum(const char* name, T value, size_t) {
    out_[name] = NameOf(value);
  }
  template <typename T, size_t kCount>
  void Named(const char* name, T value, const Name<T> (&names)[kCount]) {
    out_[name] = std::ranges::find(names, value, &Name<T>::first)->second;
  }
  void IfAny(const char* name, bool value) {
    if (value) out_[name] = true;
  }
  void IfAny(const char* name, const std::optional<double>& value) {
    if (value) out_[name] = Rounded(*value);
  }
  template <typename T, typename Visit>
  void OrNull(const char* name, const std::optional<T>& value, const Visit& visit) {
    out_[name] = nullptr;
    if (value) visit(*value);
  }
  template <typename Make>
  void Derived(const char* name, const Make& make) {
    out_[name] = make();
  }
  template <typename T>
  void Object(const char* name, const T& value) {
    Writer item;
    Members(item, value);
    out_[name] = item.Take();
  }
  template <typename Visit>
  void List(const char* name, size_t size, size_t, const Visit& each) {
    json::array& out = (out_[name] = json::array()).get_array();
    for (size_t i = 0; i < size; ++i) {
      Writer item;
      each(item, i);
      out.push_back(item.Take());
    }
  }

 private:
  json::object out_;
};

// Reads members of one object; the first trouble is kept and everything after it is empty.
// Not the strict reader of common/scene: a score of a newer server may hold members that this
// program does not know (score.h).
class Reader {
 public:
  static constexpr bool kWrites = false;
  Reader(const json::value& value, std::string path, Status& status)
      : object_(value.if_object()), path_(std::move(path)), status_(status) {
    if (!object_) Fail(path_, "an object");
  }

  void operator()(const char* name, std::string& out) {
    if (const json::value* v = Member(name)) {
      if (v->is_string())
        out = std::string(v->get_string());
      else
        Fail(Path(name), "text");
    }
  }
  void operator()(const char* name, bool& out) {
    if (const json::value* v = Member(name)) {
      if (v->is_bool())
        out = v->get_bool();
      else
        Fail(Path(name), "true or false");
    }
  }
  template <std::integral T>
  void operator()(const char* name, T& out) {
    if (const json::value* v = Member(name)) {
      boost::system::error_code error;
      auto number = v->to_number<T>(error);
      if (error)
        Fail(Path(name), "a whole number in range");
      else
        out = number;
    }
  }
  // A number with more digits is read as it would be written, so that it is written alike again.
  void operator()(const char* name, double& out, double unit = 1) {
    if (const json::value* v = Member(name)) Number(*v, name, "a number", unit, out);
  }
  void operator()(const char* name, dvec3& out, double unit = 1) {
    const json::array* list = Array(name, 3);
    if (!list) return;
    if (list->size() != 3) return Fail(Path(name), "three numbers");
    for (size_t i = 0; i < 3; ++i)
      Number((*list)[i], name, "three numbers", unit, out[static_cast<int>(i)]);
  }
  void operator()(const char* name, std::vector<double>& out, double unit, size_t max_size) {
    const json::array* list = Array(name, max_size);
    for (size_t i = 0; list != nullptr && i < list->size(); ++i)
      Number((*list)[i], name, "numbers", unit, out.emplace_back());
  }
  void operator()(const char* name, std::vector<std::string>& out, size_t max_size) {
    const json::array* list = Array(name, max_size);
    for (size_t i = 0; list != nullptr && i < list->size(); ++i) {
      if (!(*list)[i].is_string()) return Fail(Path(name), "texts");
      out.emplace_back((*list)[i].get_string());
    }
  }
  // One of the first `count` values of T.
  template <typename T>
  void Enum(const char* name, T& out, size_t count) {
    OneOf(name, count, out, [](size_t i) {
      return std::pair(static_cast<T>(i), std::string_view(NameOf(static_cast<T>(i))));
    });
  }
  template <typename T, size_t kCount>
  void Named(const char* name, T& out, const Name<T> (&names)[kCount]) {
    OneOf(name, kCount, out, [&](size_t i) { return names[i]; });
  }
  template <typename T>
  void IfAny(const char* name, T& out) {
    if (!object_ || !object_->contains(name)) return;
    if constexpr (std::same_as<T, bool>)
      (*this)(name, out);
    else
      (*this)(name, out.emplace());
  }
  template <typename T, typename Visit>
  void OrNull(const char* name, std::optional<T>& out, const Visit& visit) {
    if (const json::value* v = Member(name); v != nullptr && !v->is_null()) visit(out.emplace());
  }
  template <typename Make>
  void Derived(const char*, const Make&) {}
  template <typename T>
  void Object(const char* name, T& out) {
    const json::value* v = Member(name);
    if (v == nullptr) return;
    Reader item(*v, Path(name), status_);
    Members(item, out);
  }
  template <typename Visit>
  void List(const char* name, size_t, size_t max_size, const Visit& each) {
    const json::array* list = Array(name, max_size);
    for (size_t i = 0; list != nullptr && i < list->size(); ++i) {
      Reader item((*list)[i], Path(name) + "[" + std::to_string(i) + "]", status_);
      each(item, i);
    }
  }

 private:
  const json::value* Member(const char* name) {
    if (!object_ || !status_.ok()) return nullptr;
    const json::value* v = object_->if_contains(name);
    if (!v) Fail(Path(name), "a member of this name");
    return v;
  }
  const json::array* Array(const char* name, size_t max_size) {
    const json::value* v = Member(name);
    if (!v) return nullptr;
    if (const json::array* array = v->if_array(); array && array->size() <= max_size) return array;
    Fail(Path(name), "a list of at most " + std::to_string(max_size));
    return nullptr;
  }
  void Number(const json::value& v, const char* name, const char* expected, double unit,
              double& out) {
    if (v.is_number())
      out = Rounded(v.to_number<double>()) * unit;
    else
      Fail(Path(name), expected);
  }
  template <typename T, typename At>
  void OneOf(const char* name, size_t count, T& out, const At& at) {
    std::string text, all;
    (*this)(name, text);
    if (!status_.ok()) return;
    for (size_t i = 0; i < count; ++i) {
      const auto [value, known] = at(i);
      if (known == text) {
        out = value;
        return;
      }
      all += (i == 0 ? "" : ", ") + std::string(known);
    }
    Fail(Path(name), "one of " + all + ", found \"" + text + "\"");
  }
  std::string Path(const char* name) const { return path_.empty() ? name : path_ + "." + name; }
  void Fail(const std::string& path, const std::string& expected) {
    if (status_.ok()) {
      status_ = Status(Code::kInvalidInput, "score, " + path + ": expected " + expected, path);
    }
  }
  const json::object* object_;
  std::string path_;
  Status& status_;
};

static Result<json::value> DocumentOf(std::string_view text, json::storage_ptr memory) {
  if (text.size() > kMaxScoreJsonBytes) {
    return Status(Code::kTooLarge, "score: expected at most " + std::to_string(kMaxScoreJsonBytes) +
                                       " bytes, found " + std::to_string(text.size()));
  }
  boost::system::error_code error;
  json::parse_options options;
  // A score has four levels; a deeper document is not a score.
  options.max_depth = 8;
  json::value value = json::parse(text, error, std::move(memory), options);
  if (error) return Status(Code::kInvalidInput, "score: not JSON: " + error.message());
  return value;
}

}  // namespace stored

namespace json = boost::json;
using namespace stored;

std::string ToJson(const ScoreResult& result) {
  Writer out;
  Members(out, result);
  return json::serialize(out.Take());
}

Result<ScoreResult> PointsFromJson(std::string_view text) {
  json::monotonic_resource memory(2 * text.size());
  ENAMEL_ASSIGN_OR_RETURN(const json::value value, DocumentOf(text, &memory));
  Status status;
  ScoreResult out;
  Reader reader(value, "", status);
  Each(reader, "criteria", out.criteria, kMaxCriteria);
  Each(reader, "mistakes", out.mistakes, kMaxMistakes);
  ENAMEL_RETURN_IF_ERROR(status);
  return out;
}

Result<ScoreResult> ScoreFromJson(std::string_view text) {
  ENAMEL_ASSIGN_OR_RETURN(const json::value value, DocumentOf(text, {}));
  Status status;
  ScoreResult out;
  Reader reader(value, "", status);
  Members(reader, out);
  ENAMEL_RETURN_IF_ERROR(status);
  return out;
}

}  // namespace enamel::scoring
