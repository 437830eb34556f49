#pragma once

#include <boost/asio/awaitable.hpp>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "common/base/uuid.h"
#include "server/auth/authenticator.h"
#include "server/auth/first_admin.h"
#include "server/http/message.h"
#include "server/http/shared_bodies.h"
#include "server/jobs/backup_run.h"
#include "server/jobs/exercise_trial.h"
#include "server/jobs/tooth_import.h"
#include "server/live/live_board.h"
#include "server/live/live_cuts.h"
#include "server/live/station_board.h"
#include "server/ops/budgets.h"
#include "server/ops/metrics.h"
#include "server/storage/store.h"
#include "server/storage/store_pool.h"
#include "server/storage/upkeep/readiness.h"

// The API's table of routes, and what a handler gets. operations.cmake makes the table of the contract,
// schemas/api/openapi.yaml.
namespace enamel::server::http {

class Api;

// Who may call a route at all. server/training/access.h decides whose data the answer may hold.
enum class Need : uint8_t {
  kNobody,      // no session asked for
  kPerson,      // any signed-in person
  kInstructor,  // instructor or admin
  kAdmin,
};

// The metrics of GET /metrics. Besides this machine, callers with `token` as bearer token get them.
struct Monitoring {
  const ops::Metrics* metrics = nullptr;  // none: there is no such path
  std::string token;                      // none when empty
  // What the school's other servers measure (ReadinessOf); none: there are none.
  std::function<std::optional<PeersView>()> peers{};
  // The use of budgets that all schools of the server share (Api::Budgets); none: there are none.
  std::function<std::vector<ops::BudgetUse>()> budgets{};
};

// The input of a handler. References outlive the call.
struct Call {
  const Request& request;
  auth::Authenticator& authenticator;
  const auth::Identity* caller = nullptr;  // set unless the route needs nobody
  Uuid id;                                 // of `{id}` in the pattern
  std::string_view name = {};              // of `{name}`: 1 to 64 of a-z 0-9 _ -
  const Monitoring* monitoring = nullptr;  // always set
  LiveBoard* live = nullptr;               // none: nothing can be watched
  // Of the certificate that stations know the server by, in hexadecimal; empty: it takes none.
  std::string_view station_fingerprint = {};
  uint16_t station_port = 0;  // where they reach it; 0: not known
  StorePool* apart =
      nullptr;  // always set: for what asks a disk and must not wait for the database
  auth::FirstAdmin* first_admin = nullptr;  // none: no link was given
  StationBoard* stations = nullptr;         // none: it takes none
  ToothImport* teeth = nullptr;             // always set
  BackupRun* backups = nullptr;             // always set
  ExerciseTrials* trials = nullptr;         // always set
  LiveCuts* cuts = nullptr;                 // always set
  bool draining = false;                    // about to stop: others shall be asked
  SharedBodies* bodies = nullptr;           // always set
  const Api* api = nullptr;                 // always set
};

// Runs on the store's threads and may block.
using BlockingHandler = Result<Response> (*)(const Call&, Store&);
// Runs on the connection's strand and must not block.
using AsyncHandler = boost::asio::awaitable<Result<Response>> (*)(Call, Store&);

struct Route {
  Method method;
  std::string_view pattern;  // "/api/v1/attempts/{id}/score"
  Need need;
  std::variant<BlockingHandler, AsyncHandler> handler;
};

std::span<const Route> Routes();

struct RouteMatch {
  const Route* route = nullptr;  // none: no such path, or not with this method
  std::string_view id;           // text in the place of `{id}` or `{name}`
  std::string allowed_methods;   // "GET, POST" when the path exists; else empty
};
// HEAD finds the GET route.
RouteMatch FindRoute(Method method, std::string_view path);

}  // namespace enamel::server::http
