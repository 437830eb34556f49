#include "server/http/routes.h"

#include <array>

#include "server/http/operations.h"

namespace enamel::server::http {
namespace {

const std::array kRoutes = {
#include "server/http/routes.inc"
};

// The text in the place of `{…}` (empty for a pattern without), none when the path does not match.
std::optional<std::string_view> Match(std::string_view pattern, std::string_view path) {
  size_t place = pattern.find('{');
  if (place == std::string_view::npos) {
    return pattern == path ? std::optional(std::string_view{}) : std::nullopt;
  }
  std::string_view before = pattern.substr(0, place);
  std::string_view after = pattern.substr(pattern.find('}') + 1);
  if (path.size() <= before.size() + after.size() || !path.starts_with(before) ||
      !path.ends_with(after)) {
    return std::nullopt;
  }
  std::string_view id = path.substr(before.size(), path.size() - before.size() - after.size());
  // Else "/people/{id}" would also match "/people/1/password".
  return id.find('/') == std::string_view::npos ? std::optional(id) : std::nullopt;
}

}  // namespace

std::span<const Route> Routes() { return kRoutes; }

RouteMatch FindRoute(Method method, std::string_view path) {
  // HEAD is GET without the body, which the connection leaves out.
  Method wanted = method == Method::kHead ? Method::kGet : method;
  RouteMatch out;
  // One after another: some eighty comparisons of short texts, next to a query to the database. The
  // loop reads the whole table because a 405 has to name the allowed methods.
  for (const Route& route : kRoutes) {
    std::optional<std::string_view> id = Match(route.pattern, path);
    if (!id) continue;
    if (!out.allowed_methods.empty()) out.allowed_methods += ", ";
    out.allowed_methods += MethodName(route.method);
    if (route.method == Method::kGet) out.allowed_methods += ", HEAD";
    if (route.method != wanted) continue;
    out.route = &route;
    out.id = *id;
  }
  return out;
}

}  // namespace enamel::server::http
