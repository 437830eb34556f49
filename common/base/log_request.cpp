#include "common/base/log_request.h"

#include <sodium.h>

#include <algorithm>
#include <array>

#include "common/base/hex.h"

namespace enamel {
namespace {

constexpr size_t kMaxIdBytes = 64;

thread_local std::string_view current, attempt;

}  // namespace

LogRequest::LogRequest(std::string_view id) : before_(current) { current = id; }

LogRequest::~LogRequest() { current = before_; }

std::string_view LogRequest::Current() { return current; }

LogAttempt::LogAttempt(const Uuid& id)
    : before_(attempt), id_(id.IsZero() ? std::string() : id.Text()) {
  attempt = id_;
}

LogAttempt::~LogAttempt() { attempt = before_; }

std::string_view LogAttempt::Current() { return attempt; }

std::string LogRequest::NewId() {
  std::array<uint8_t, 6> bytes;
  randombytes_buf(bytes.data(), bytes.size());
  return ToHex(bytes);
}

bool LogRequest::IsId(std::string_view text) {
  return !text.empty() && text.size() <= kMaxIdBytes && std::ranges::all_of(text, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' ||
           c == '_' || c == '-';
  });
}

}  // namespace enamel
