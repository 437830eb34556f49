#pragma once

#include <boost/json.hpp>
#include <cmath>
#include <string>

// The part of JSON Schema that the documents in schemas/ use: type, const, enum, required,
// properties, additionalProperties: false, items, minItems, maxItems, minimum, maximum, minLength,
// maxLength, $ref into $defs. Any other keyword, except a comment, is an error: nothing goes
// unchecked.
namespace enamel::test {

// Empty if `value` conforms to `schema`, else the error and its place.
inline std::string WhyNotOfSchema(const boost::json::value& value,
                                  const boost::json::object& schema,
                                  const boost::json::object& root, const std::string& at = "") {
  namespace json = boost::json;
  auto wrong = [&](const std::string& what) { return (at.empty() ? "/" : at) + ": " + what; };
  auto is = [&](std::string_view type) {
    if (type == "object") return value.is_object();
    if (type == "array") return value.is_array();
    if (type == "string") return value.is_string();
    if (type == "boolean") return value.is_bool();
    if (type == "null") return value.is_null();
    if (type == "number") return value.is_number();
    return type == "integer" && value.is_number() &&
           std::floor(value.to_number<double>()) == value.to_number<double>();
  };
  for (const auto& [key, rule] : schema) {
    if (key == "$schema" || key == "$id" || key == "title" || key == "description" ||
        key == "$defs")
      continue;
    if (key == "$ref") {
      std::string name(rule.as_string().subview(sizeof("#/$defs/") - 1));
      std::string why = WhyNotOfSchema(value, root.at("$defs").at(name).as_object(), root, at);
      if (!why.empty()) return why;
    } else if (key == "type") {
      bool found = rule.is_string() && is(rule.as_string());
      if (rule.is_array()) {
        for (const json::value& t : rule.as_array()) found = found || is(t.as_string());
      }
      if (!found)
        return wrong("expected type " + json::serialize(rule) + ", found " +
                     json::serialize(value).substr(0, 40));
    } else if (key == "const") {
      if (value != rule) return wrong("expected " + json::serialize(rule));
    } else if (key == "enum") {
      bool found = false;
      for (const json::value& one : rule.as_array()) found = found || one == value;
      if (!found)
        return wrong("expected one of " + json::serialize(rule) + ", found " +
                     json::serialize(value));
    } else if (key == "required") {
      for (const json::value& name : rule.as_array()) {
        if (value.is_object() && !value.as_object().contains(name.as_string()))
          return wrong("no member " + json::serialize(name));
      }
    } else if (key == "properties" || key == "additionalProperties") {
      if (!value.is_object()) continue;
      const json::object& known = schema.at("properties").as_object();
      for (const auto& [name, member] : value.as_object()) {
        const json::value* of = known.if_contains(name);
        if (of == nullptr) {
          if (key == "additionalProperties" && rule == json::value(false))
            return wrong("unknown member " + std::string(name));
          continue;
        }
        if (key == "additionalProperties") continue;
        std::string why =
            WhyNotOfSchema(member, of->as_object(), root, at + "/" + std::string(name));
        if (!why.empty()) return why;
      }
    } else if (key == "items") {
      if (!value.is_array()) continue;
      for (size_t i = 0; i < value.as_array().size(); ++i) {
        std::string why = WhyNotOfSchema(value.as_array()[i], rule.as_object(), root,
                                         at + "/" + std::to_string(i));
        if (!why.empty()) return why;
      }
    } else if (key == "minItems" || key == "maxItems") {
      if (!value.is_array()) continue;
      const auto n = static_cast<int64_t>(value.as_array().size());
      if (key == "minItems" ? n < rule.as_int64() : n > rule.as_int64())
        return wrong(std::to_string(n) + " items");
    } else if (key == "minLength" || key == "maxLength") {
      if (!value.is_string()) continue;
      const auto n = static_cast<int64_t>(value.as_string().size());
      if (key == "minLength" ? n < rule.as_int64() : n > rule.as_int64())
        return wrong(std::to_string(n) + " characters");
    } else if (key == "minimum" || key == "maximum") {
      if (!value.is_number()) continue;
      const double v = value.to_number<double>(), bound = rule.to_number<double>();
      if (key == "minimum" ? v < bound : v > bound) return wrong("found " + std::to_string(v));
    } else {
      return wrong("the checker does not know the keyword " + std::string(key));
    }
  }
  return "";
}

}  // namespace enamel::test
