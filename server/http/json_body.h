#pragma once

#include <array>
#include <boost/json.hpp>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.h"
#include "common/base/uuid.h"
#include "server/http/message.h"

// JSON in and out of messages.
namespace enamel::server::http {

Response JsonResponse(const boost::json::object& object, int status = 200);

// The body as an object with exactly these members, each a string of 1..max_length bytes.
struct TextMember {
  std::string_view name;
  size_t max_length;
};
// Errors: kInvalidInput with the member in field(), kTooLarge (before anything is parsed). Requires: Content-Type was checked (IsJson).
Result<boost::json::object> TextMembers(const Request& request,
                                        std::initializer_list<TextMember> members);

// No plain body of the API is nested deeper.
inline constexpr size_t kPlainDepth = 4;

// Takes a body of several types apart, member by member. The first problem is kept and everything
// after it answers its default, so that a handler asks for all it wants and looks once:
//   BodyReader body(request);
//   row.text = body.Text("text", 1, 2000);
//   if (Status status = body.Finish(); !status.ok()) …
// Errors (Finish): kInvalidInput with the member in field(): missing, of another type or size, or
// not asked for. Requires: Content-Type was checked (IsJson).
class BodyReader {
 public:
  // `max_depth`: more with a document inside (Document), as far as its format goes.
  explicit BodyReader(const Request& request, size_t max_depth = kPlainDepth);

  // Whether the member exists; optional members are read only then.
  bool Has(std::string_view name) const { return object_.if_contains(name) != nullptr; }
  // UTF-8 bytes; control characters other than line feed and tab are refused.
  std::string Text(std::string_view name, size_t at_least, size_t at_most);
  int64_t Integer(std::string_view name, int64_t at_least, int64_t at_most);
  // `otherwise` when the member is absent.
  int64_t Integer(std::string_view name, int64_t at_least, int64_t at_most, int64_t otherwise);
  double Number(std::string_view name, double at_least, double at_most);
  bool Flag(std::string_view name);
  bool Flag(std::string_view name, bool otherwise);
  std::optional<Uuid> MaybeId(std::string_view name);            // none: null or absent
  std::vector<Uuid> Ids(std::string_view name, size_t at_most);  // none: absent
  // An object, as JSON text: for the parser of the document that it is.
  std::string Document(std::string_view name);
  // Exactly three; none: null or absent.
  std::optional<std::array<int32_t, 3>> MaybePoint(std::string_view name);
  // Lists of points, each of three numbers within ten metres; none: absent. The points in each are for the caller to count.
  using Curve = std::vector<std::array<double, 3>>;
  std::vector<Curve> Curves(std::string_view name, size_t at_most);

  Status Finish();

 private:
  const boost::json::value* Find(std::string_view name);
  const boost::json::value* Need(std::string_view name, const std::string& expected);
  void Refuse(std::string_view name, const std::string& expected);

  boost::json::object object_;
  std::vector<std::string> asked_;
  Status status_;
};

// False unless the Content-Type is application/json: a form of another site cannot send that.
bool IsJson(const Request& request);
Response NotJson();

}  // namespace enamel::server::http
