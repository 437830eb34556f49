#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "common/base/check.h"

namespace enamel {

// The kind of refusal. Boundaries translate it exactly once: to an exit code in a program's main,
// to an HTTP status in server/http, to a wire error in server/stations.
enum class Code {
  kOk = 0,
  kInvalidInput,     // malformed or out of range: the caller must change what was sent
  kUnauthenticated,  // no or expired identity
  kForbidden,        // identity known, right missing
  kNotFound,
  kConflict,     // contradicts what is stored (same key, other content; stale edit)
  kTooLarge,     // over a stated bound
  kUnavailable,  // peer or resource not reachable now; trying later may help
  kStorage,      // disk or database failed
  kVersion,      // a format, schema or core version this program does not speak
  kInternal,
};

// Stable lower-case name of a code, as the API and logs print it ("not_found").
constexpr const char* CodeName(Code code) {
  switch (code) {
    case Code::kOk:
      return "ok";
    case Code::kInvalidInput:
      return "invalid_input";
    case Code::kUnauthenticated:
      return "unauthenticated";
    case Code::kForbidden:
      return "forbidden";
    case Code::kNotFound:
      return "not_found";
    case Code::kConflict:
      return "conflict";
    case Code::kTooLarge:
      return "too_large";
    case Code::kUnavailable:
      return "unavailable";
    case Code::kStorage:
      return "storage";
    case Code::kVersion:
      return "version";
    case Code::kInternal:
      return "internal";
  }
  return "internal";
}

// An outcome that depends on input, peer, file or learner. The message gives the expected value,
// the value found, and what to do; `field` names the offending field or offset where there is one.
// Thread safety: a value. Real-time: not safe (owns strings).
class [[nodiscard]] Status {
 public:
  Status() = default;
  Status(Code code, std::string message, std::string field = {})
      : code_(code), message_(std::move(message)), field_(std::move(field)) {}

  static Status Ok() { return {}; }
  bool ok() const { return code_ == Code::kOk; }
  Code code() const { return code_; }
  const std::string& message() const { return message_; }
  const std::string& field() const { return field_; }
  // Seconds after which trying again makes sense; 0: not known.
  int32_t retry_after_s() const { return retry_after_s_; }
  Status& RetryAfter(int32_t seconds) {
    retry_after_s_ = seconds;
    return *this;
  }

 private:
  Code code_ = Code::kOk;
  int32_t retry_after_s_ = 0;
  std::string message_;
  std::string field_;
};

// A value, or the Status that explains why there is none; shaped like std::expected (C++23) so that
// it can be replaced. Requires: `value()` only when `ok()`.
template <typename T>
class [[nodiscard]] Result {
 public:
  Result(T value) : state_(std::move(value)) {}        // NOLINT: implicit on purpose
  Result(Status status) : state_(std::move(status)) {  // NOLINT: implicit on purpose
    ENAMEL_CHECK(!std::get<Status>(state_).ok());
  }

  bool ok() const { return std::holds_alternative<T>(state_); }
  explicit operator bool() const { return ok(); }
  T& value() & {
    ENAMEL_CHECK(ok());
    return std::get<T>(state_);
  }
  const T& value() const& {
    ENAMEL_CHECK(ok());
    return std::get<T>(state_);
  }
  T&& value() && {
    ENAMEL_CHECK(ok());
    return std::get<T>(std::move(state_));
  }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }
  T& operator*() & { return value(); }
  const T& operator*() const& { return value(); }
  T&& operator*() && { return std::move(*this).value(); }
  const Status& status() const {
    static const Status kOkStatus;
    return ok() ? kOkStatus : std::get<Status>(state_);
  }

 private:
  std::variant<T, Status> state_;
};

// Returns the Status of `expr` from the enclosing function when it is not ok.
#define ENAMEL_RETURN_IF_ERROR(expr)                                                           \
  do {                                                                                         \
    if (::enamel::Status enamel_status_ = (expr); !enamel_status_.ok()) return enamel_status_; \
  } while (false)

// Declares `declaration` with the value of a Result, or returns its Status from the enclosing
// function when it is not ok. For functions that return a Status or a Result; not for coroutines,
// which say co_return. The declaration has no comma outside parentheses; the expression may.
//   ENAMEL_ASSIGN_OR_RETURN(const Bytes bytes, ReadFile(path, kMaxBytes));
#define ENAMEL_ASSIGN_OR_RETURN(declaration, ...) \
  ENAMEL_ASSIGN_OR_RETURN_IN_(ENAMEL_JOIN_(enamel_result_, __LINE__), declaration, (__VA_ARGS__))
#define ENAMEL_ASSIGN_OR_RETURN_IN_(result, declaration, expr) \
  auto result = expr;                                          \
  if (!result.ok()) return result.status();                    \
  declaration = std::move(result).value()
#define ENAMEL_JOIN_(a, b) ENAMEL_JOIN_NOW_(a, b)
#define ENAMEL_JOIN_NOW_(a, b) a##b

}  // namespace enamel
