#include "server/http/request_places.h"

#include <gtest/gtest.h>

#include <vector>

#include "server/http/site.h"

// Nobody takes all requests that may be under way at once.
namespace enamel::server::http {
namespace {

Request From(const std::string& peer, const std::string& cookie = {}) {
  Request out;
  out.peer = peer;
  if (!cookie.empty()) out.headers["cookie"] = SessionCookieName(false) + "=" + cookie;
  return out;
}

// As many as there are places.
size_t TakeAll(RequestPlaces& places, const Request& request,
               std::vector<std::shared_ptr<void>>& held) {
  size_t taken = 0;
  while (auto place = places.Take(request).held) {
    held.push_back(std::move(place));
    ++taken;
  }
  return taken;
}

TEST(RequestPlacesTest, APersonWhoTakesAllOfTheirsLeavesOthersTheirs) {
  RequestPlaces places(64);
  std::vector<std::shared_ptr<void>> held, others;
  const Request student = From("192.0.2.1", "aa"), again = From("198.51.100.7", "bb");
  const Uuid person = Uuid::New();
  places.Know(student, person);
  places.Know(again, person);
  const auto most = static_cast<size_t>(ops::Budgets{}.person_requests);
  EXPECT_EQ(TakeAll(places, student, held), most);
  EXPECT_EQ(places.Uses().of, person.Text());
  EXPECT_EQ(places.Uses().most, most);
  EXPECT_EQ(places.Take(again).held, nullptr) << "another session of the same person";
  const Request neighbour = From("192.0.2.1", "cc");
  places.Know(neighbour, Uuid::New());
  EXPECT_EQ(TakeAll(places, neighbour, others), most);
  held.clear();
  EXPECT_NE(places.Take(student).held, nullptr) << "given back";
}

TEST(RequestPlacesTest, AnAddressWithoutSessionsLeavesAQuarter) {
  RequestPlaces places(64);
  std::vector<std::shared_ptr<void>> held;
  size_t taken = TakeAll(places, From("192.0.2.1"), held);
  // Cookies that nobody gave out are none.
  for (const char* made_up : {"x", "y", "z"})
    taken += TakeAll(places, From("192.0.2.1", made_up), held);
  EXPECT_EQ(taken, 48u);
  EXPECT_NE(places.Take(From("198.51.100.7")).held, nullptr);
}

}  // namespace
}  // namespace enamel::server::http
