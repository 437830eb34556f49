#include <algorithm>
#include <boost/json.hpp>
#include <exception>
#include <map>
#include <set>
#include <tuple>

#include "common/base/log_request.h"
#include "common/fidelity/feel.h"
#include "common/scene/builtin/builtin.h"
#include "common/scene/json/json.h"
#include "server/http/error_response.h"
#include "server/http/handlers/feel_maps.h"
#include "server/http/handlers/handlers.h"
#include "server/http/json_body.h"

// The forces that a hand can feel of these tissues on one device.
namespace enamel::server::http {
namespace json = boost::json;
namespace {

// Bounds on one answer's work: 8 cells a tissue, about 10 ms each.
constexpr size_t kMostScenes = 64;
constexpr size_t kMostTissues = 12;

// Tissues that differ in name only feel the same: one row.
struct TissueRow {
  scene::TissueSpec spec;
  std::set<std::string> names;
  std::set<std::string> scenes;
};

struct Tissues {
  std::vector<TissueRow> rows;  // hard to soft
  bool from_scenes = false;     // else those of the built-in scenes
  size_t left_out = 0;          // beyond kMostTissues
};

Result<scene::Scene> SceneOf(StoredBlobs& blobs, const SceneRow& row) {
  Result<Bytes> text = blobs.GetBlob(row.content);
  if (!text.ok()) return text.status();
  return scene::SceneFromJson(AsText(*text));
}

// Those of the scenes this server has; of the built-in scenes when there are none that can be read.
Result<Tissues> TissuesHere(StoredBlobs& blobs, SceneRows& scenes_rows) {
  Result<std::vector<SceneRow>> scenes = scenes_rows.Scenes();
  if (!scenes.ok()) return scenes.status();
  using Feel = std::tuple<int32_t, int32_t, int32_t>;
  // Ordered by damping first, hence hard to soft.
  std::map<Feel, TissueRow, std::greater<>> found;
  auto Add = [&](const scene::TissueSpec& spec, const std::string& scene) {
    // Without damping there is nothing to feel and nothing to divide by.
    if (spec.tissue == cutting::Tissue::kAir || spec.damping_mn_s_per_mm <= 0) return;
    TissueRow& row = found[{spec.damping_mn_s_per_mm, spec.coulomb_mn, spec.threshold_mn}];
    row.spec = spec;
    row.names.emplace(cutting::TissueName(spec.tissue));
    if (!scene.empty()) row.scenes.insert(scene);
  };
  Tissues out;
  for (size_t i = 0; i < scenes->size() && i < kMostScenes; ++i) {
    Result<scene::Scene> scene = SceneOf(blobs, (*scenes)[i]);
    // A scene that cannot be read is another page's to complain about; the map of the others is
    // right without it.
    if (!scene.ok()) continue;
    for (const scene::TissueSpec& spec : scene->tissues) Add(spec, scene->title);
  }
  out.from_scenes = !found.empty();
  if (!out.from_scenes) {
    using cutting::Tissue;
    for (const scene::TissueSpec& spec :
         scene::DefaultTissues({Tissue::kEnamel, Tissue::kFilling, Tissue::kDentin, Tissue::kGypsum,
                                Tissue::kCaries, Tissue::kPulp, Tissue::kNeighbour}))
      Add(spec, "");
  }
  for (auto& [feel, row] : found) {
    if (out.rows.size() < kMostTissues) {
      out.rows.push_back(std::move(row));
    } else {
      ++out.left_out;
    }
  }
  return out;
}

json::array TextsJson(const std::set<std::string>& texts) {
  return json::array(texts.begin(), texts.end());
}

json::array TissuesJson(const Tissues& tissues) {
  json::array out;
  for (const TissueRow& row : tissues.rows) {
    out.push_back({{"names", TextsJson(row.names)},
                   {"damping_mn_s_per_mm", row.spec.damping_mn_s_per_mm},
                   {"coulomb_mn", row.spec.coulomb_mn},
                   {"threshold_mn", row.spec.threshold_mn},
                   {"provenance", row.spec.provenance},
                   {"scenes", TextsJson(row.scenes)}});
  }
  return out;
}

json::object FiguresJson(fidelity::Motion motion, const fidelity::Figures& f) {
  bool steady = motion == fidelity::Motion::kSteady;
  json::value lag, rise;
  // A lag is defined for a motion that comes back, a rise for one that does not; the other is null
  // and not 0.
  if (!steady) lag = f.lag_s;
  if (steady && f.rise_s >= 0) rise = f.rise_s;
  return {{"error", f.error}, {"gain", f.gain}, {"lag_s", lag}, {"rise_s", rise}};
}

json::array CellsJson(const std::vector<fidelity::Cell>& cells) {
  json::array out;
  for (const fidelity::Cell& cell : cells) {
    out.push_back({{"tissue", cell.tissue},
                   {"speed_mm_per_s", cell.speed_m_per_s * 1e3},
                   {"motion", fidelity::MotionName(cell.motion)},
                   {"force_rms_n", cell.rms_n},
                   {"force_largest_n", cell.largest_n},
                   {"law", FiguresJson(cell.motion, cell.law)},
                   {"oracle", FiguresJson(cell.motion, cell.oracle)},
                   {"verdict", fidelity::VerdictName(cell.verdict)}});
  }
  return out;
}

json::array ThresholdsJson() {
  json::array out;
  for (const fidelity::Threshold& t : fidelity::Thresholds()) {
    out.push_back({{"name", t.name}, {"value", t.value}, {"unit", t.unit}, {"source", t.source}});
  }
  return out;
}

Result<scene::DeviceProfile> NewestDocument(StoredBlobs& blobs, const ProfileRow& row) {
  Result<Bytes> bytes = blobs.GetBlob(row.content);
  if (!bytes.ok()) return Status{Code::kInternal, bytes.status().message()};
  Result<scene::DeviceProfile> profile = scene::ProfileFromJson(AsText(*bytes));
  if (!profile.ok()) return Status{Code::kInternal, profile.status().message()};
  return profile;
}

Response Answer(const Call& call, Store& store) {
  Result<std::vector<ProfileRow>> rows = store.profiles.ProfileVersions(std::string(call.name));
  if (!rows.ok()) return ErrorResponse(rows.status());
  if (rows->empty()) {
    return ErrorResponse(Status{Code::kNotFound, "there is no such device profile", "name"});
  }
  Result<scene::DeviceProfile> profile = NewestDocument(store.blobs, rows->front());
  if (!profile.ok()) return ErrorResponse(profile.status());
  Result<Tissues> tissues = TissuesHere(store.blobs, store.scenes);
  if (!tissues.ok()) return ErrorResponse(tissues.status());
  Result<fidelity::AttachedDevice> attached = fidelity::Attached(*profile);
  // The request is valid, but the stored data cannot be used.
  if (!attached.ok()) {
    return ErrorResponse(
        Status{Code::kConflict, attached.status().message(), attached.status().field()});
  }
  std::vector<fidelity::Tissue> wanted;
  for (const TissueRow& row : tissues->rows) wanted.push_back(fidelity::TissueOf(row.spec));
  json::array cells;
  const bool has_motors = fidelity::HasMotors(*profile);
  // A mouse is in the list of devices too, and has nothing to feel with: no cells, and the page
  // says so.
  if (has_motors) cells = CellsJson(*call.feel->Of(attached->device, wanted));
  return JsonResponse(
      {{"name", profile->name},
       {"title", profile->title},
       {"version", rows->front().version},
       {"has_motors", has_motors},
       {"coupling_mn_per_mm", static_cast<int64_t>(attached->device.kc_n_per_m + 0.5)},
       {"delay_ticks", attached->device.delay_ticks},
       {"delay_measured", attached->delay.from == scene::DelayUsed::From::kProfile},
       {"thresholds", ThresholdsJson()},
       {"tissues", TissuesJson(*tissues)},
       {"tissues_of_scenes", tissues->from_scenes},
       {"tissues_left_out", tissues->left_out},
       {"cells", std::move(cells)}});
}

}  // namespace

boost::asio::awaitable<Response> GetProfileFeel(Call call, Store& store) {
  // A thread of its own: a map takes up to a second, and its cache then needs no lock.
  co_return co_await call.feel->thread().Run([&call, &store]() -> Response {
    const LogRequest logged(call.request.id);
    try {
      return Answer(call, store);
    } catch (const std::exception& error) {
      return ErrorResponse(Status{Code::kInternal, error.what(), call.request.path});
    }
  });
}

}  // namespace enamel::server::http
