#include <algorithm>
#include <array>
#include <boost/json.hpp>
#include <cmath>
#include <numbers>
#include <vector>

#include "station/devices/trouble.h"
#include "station/sdk/answering.h"
#include "station/sdk/buses.h"
#include "station/sdk/web_socket.h"

// Haply's Inverse3 with a VerseGrip, through the maker's service on this computer: JSON over a
// WebSocket, as docs.haply.co describes it (inverseSDK/service/realtime). Its axes are the scene's.
namespace enamel::station::sdk {
namespace {

namespace json = boost::json;

constexpr const char* kHost = "localhost";
constexpr const char* kPort = "10001";
// The models, as the service's config.type and our profiles name them.
struct Model {
  std::string_view type;
  const char* name;
};
constexpr std::array kModels = {Model{"inverse3", "Inverse3"}, Model{"inverse3x", "Inverse3x"},
                                Model{"minverse", "MinVerse"}};
constexpr std::chrono::seconds kInventoryPatience{1};
// Answers with a position and no orientation: a grip without a cable may sleep.
constexpr int kQuestionsOfAGrip = 50;
// Answers without a position to a force in one form, before the other form is tried.
constexpr int kQuestionsOfAForm = 20;
// The service's documentation names a force's member in the first way, public clients in the second.
constexpr std::array kForms = {"vector", "values"};

// The member of an object; null where `in` is no object or has no such member.
const json::value* Member(const json::value* in, std::string_view name) {
  const json::object* object = in == nullptr ? nullptr : in->if_object();
  return object == nullptr ? nullptr : object->if_contains(name);
}

double Number(const json::value* in, double otherwise) {
  if (in == nullptr || !in->is_number()) return otherwise;
  boost::system::error_code error;
  const auto out = in->to_number<double>(error);
  return error ? otherwise : out;
}

bool IsTrue(const json::value* in) { return in != nullptr && in->is_bool() && in->get_bool(); }
bool IsFalse(const json::value* in) { return in != nullptr && in->is_bool() && !in->get_bool(); }

std::string Text(const json::value* in) {
  return in != nullptr && in->is_string() ? std::string(in->get_string()) : std::string();
}

// The devices of a message's list; null: it has none.
const json::array* List(const json::value& message, std::string_view list) {
  const json::value* all = Member(&message, list);
  return all == nullptr ? nullptr : all->if_array();
}

// The device of a list with this id, or the first where `id` is empty; null: none.
const json::value* Listed(const json::value& message, std::string_view list,
                          const std::string& id) {
  const json::array* all = List(message, list);
  if (all == nullptr) return nullptr;
  for (const json::value& device : *all) {
    if (id.empty() || Text(Member(&device, "device_id")) == id) return &device;
  }
  return nullptr;
}

const Model* ModelNamed(std::string_view type) {
  const auto* found = std::ranges::find(kModels, type, &Model::type);
  return found == kModels.end() ? nullptr : found;
}
std::string TypeOf(const json::value& device) {
  return Text(Member(Member(&device, "config"), "type"));
}

std::string NameOf(const json::value& device) {
  const Model* model = ModelNamed(TypeOf(device));
  return std::string(model == nullptr ? "Haply device" : model->name) + " " +
         Text(Member(&device, "device_id"));
}
std::string UnitNamed(const std::string& id) { return "inverse3:" + id; }

// The wired grip, else the wireless one, else one that somebody built; null: none is connected.
const json::value* GripIn(const json::value& message) {
  for (const char* list : {"verse_grip", "wireless_verse_grip", "custom_verse_grip"}) {
    if (const json::value* grip = Listed(message, list, {}); grip != nullptr) return grip;
  }
  return nullptr;
}

// Why the device cannot be used now, and what to do; empty: it can.
Status WhyNotUsable(const json::value& message, const json::value& device) {
  const auto because = [](const std::string& why, const char* which) {
    return Status(Code::kUnavailable, why, which);
  };
  // Another model's force would be too much for it.
  if (const std::string type = TypeOf(device); ModelNamed(type) == nullptr) {
    return because(
        type.empty()
            ? "its service does not say which model it is (config.type): update the service"
            : "it is a model that this station does not know, '" + type +
                  "': expected inverse3, inverse3x or minverse; update the station",
        type.empty() ? trouble::kService : trouble::kModel);
  }
  const json::value* status = Member(&device, "status");
  if (IsFalse(Member(status, "power_supply")))
    return because("it has no power: connect its power supply", trouble::kPower);
  if (IsFalse(Member(status, "calibrated")))
    return because("it is not calibrated: rest its grip on the inkwell until its light is steady",
                   trouble::kInkwell);
  if (IsTrue(Member(status, "in_use")))
    return because("it is in use by another program: close that program", trouble::kInUse);
  if (IsFalse(Member(status, "ready")))
    return because("it is not ready: wait, or switch it off and on", trouble::kNotReady);
  const json::value* damping = Member(Member(Member(&device, "config"), "filters"), "damping");
  if (Number(Member(damping, "scalar"), 0) != 0)
    return because(
        "its service adds damping: set filters.damping to 0 in /etc/haply-inverse-service",
        trouble::kDamping);
  if (GripIn(message) == nullptr)
    return because(
        "no grip is connected, which has the button and turns the bur: connect the VerseGrip. With "
        "a foot pedal it can be used without; the bur then stays upright",
        trouble::kNoGrip);
  return Status::Ok();
}

// The service's first message, which lists what is attached.
Result<json::value> ReadInventory(WebSocket& socket) {
  std::string text;
  boost::system::error_code error;
  json::value out;
  if (socket.Read(text, kInventoryPatience) == WebSocket::Got::kMessage)
    out = json::parse(text, error);
  if (!out.is_object()) {
    return Status(Code::kUnavailable,
                  "expected an inventory from Haply's service, found none within a second: restart "
                  "haply-inverse-service",
                  trouble::kService);
  }
  return out;
}

class Inverse3 final : public AnsweringBus {
 public:
  Inverse3(const BusChoice& choice, std::unique_ptr<WebSocket> socket)
      : AnsweringBus(choice.peak_n, "run its service on this computer"),
        profile_(choice.profile),
        has_pedal_(choice.has_pedal),
        wanted_(choice.unit),
        socket_(std::move(socket)) {}
  // Closed at once, the connection could take the last force with it.
  ~Inverse3() override { (void)Await(patience()); }

  std::string Name() const override { return name_; }
  std::string Driver() const override { return "inverse3"; }
  std::string Unit() const override { return UnitNamed(id_); }

  // Reads what is attached, and then opens it. Errors: as Open; kNotFound, with what to do.
  Status Begin() {
    ENAMEL_RETURN_IF_ERROR(TakeInventory());
    return Open();
  }

 private:
  Got Await(std::chrono::microseconds patience) override {
    switch (socket_->Read(text_, patience)) {
      case WebSocket::Got::kMessage:
        return Got::kAnswer;
      case WebSocket::Got::kNothing:
        return Got::kNothing;
      case WebSocket::Got::kClosed:
        break;
    }
    return Got::kClosed;
  }
  Heard Understand(Pose& out) override {
    has_position_ = false;
    boost::system::error_code error;
    const json::value message = json::parse(text_, error);
    return error ? Heard::kRefused : Take(message, out);
  }
  bool Ask(const dvec3& f) override {
    const json::value newtons{{"x", f.x}, {"y", f.y}, {"z", f.z}};
    const json::object force{{kForms[form_], newtons}};
    const json::object commands{{"set_cursor_force", force}};
    json::object device{{"device_id", id_}, {"commands", commands}};
    const json::object message{{"inverse3", json::array{std::move(device)}}};
    return socket_->Write(json::serialize(message));
  }

  // The service gives a position only to a client whose force it understood. Only answers count
  // against a form: one that is merely late must not leave the other form chosen, without a force.
  Result<bool> IsReady(Heard heard, const Pose&) override {
    if (heard == Heard::kPose) return true;
    if (has_position_) {
      if (++without_grip_ < kQuestionsOfAGrip) return false;
      return Status(Code::kUnavailable,
                    Name() +
                        ": its grip sends no orientation: press a button on the grip to wake it, "
                        "or connect it again",
                    trouble::kNoGrip);
    }
    if (++without_position_ < kQuestionsOfAForm) return false;
    without_position_ = 0;
    if (++form_ < kForms.size()) return false;
    return Status(Code::kUnavailable,
                  Name() + ": its service gives no position in answer to a force, named " +
                      kForms[0] + " or " + kForms[1] + ": update the service",
                  trouble::kService);
  }
  // The wanted unit, else the first device; null: there is none.
  const json::value* Wanted(const json::value& message) const {
    if (const json::array* all = List(message, "inverse3"); all != nullptr) {
      for (const json::value& device : *all) {
        if (UnitNamed(Text(Member(&device, "device_id"))) == wanted_) return &device;
      }
    }
    return Listed(message, "inverse3", {});
  }
  Status TakeInventory() {
    ENAMEL_ASSIGN_OR_RETURN(const json::value message, ReadInventory(*socket_));
    const json::value* device = Wanted(message);
    if (device == nullptr) {
      return Status(Code::kNotFound,
                    "Haply's service finds no Inverse3: switch it on and connect it",
                    trouble::kNotAttached);
    }
    id_ = Text(Member(device, "device_id"));
    name_ = NameOf(*device);
    session_ = Text(Member(&message, "session_id"));
    has_grip_ = GripIn(message) != nullptr;
    const Status problem = WhyNotUsable(message, *device);
    const bool is_borne = problem.field() == trouble::kNoGrip && has_pedal_;
    if (!is_borne) ENAMEL_RETURN_IF_ERROR(UsableUnless(problem, Name()));
    return CheckModel(TypeOf(*device));
  }
  // A profile of another of these models has that one's force. Profiles of other names are a school's own.
  Status CheckModel(const std::string& type) const {
    if (ModelNamed(profile_) == nullptr || profile_ == type) return Status::Ok();
    return Status(Code::kConflict,
                  Name() + " needs the profile " + type + ", found " + profile_ +
                      ": choose the profile " + type,
                  trouble::kModel);
  }
  Heard Take(const json::value& message, Pose& out) {
    // A service that restarted has another session; the device's settings and calibration are lost.
    const std::string session = Text(Member(&message, "session_id"));
    if (!session.empty() && session != session_) return Heard::kGone;
    const json::value* device = Listed(message, "inverse3", id_);
    if (device == nullptr) {
      return List(message, "inverse3") == nullptr ? Heard::kRefused : Heard::kGone;
    }
    const json::value* status = Member(device, "status");
    // Its positions mean nothing then.
    if (IsFalse(Member(status, "power_supply")) || IsFalse(Member(status, "calibrated")))
      return Heard::kGone;
    const json::value* at = Member(Member(device, "state"), "cursor_position");
    if (at == nullptr) return Heard::kRefused;
    const double none = std::nan("");
    out.tip_m = {Number(Member(at, "x"), none), Number(Member(at, "y"), none),
                 Number(Member(at, "z"), none)};
    has_position_ = CanBe(out);  // its orientation is still the identity
    return !has_grip_ || TakeGrip(message, out) ? Heard::kPose : Heard::kRefused;
  }
  // False: it is away or its turn is none, and the bur must not jump to another.
  static bool TakeGrip(const json::value& message, Pose& out) {
    const json::value* state = Member(GripIn(message), "state");
    const json::value* q = Member(state, "orientation");
    const double none = std::nan("");
    const Quat grip_in_scene{Number(Member(q, "x"), none), Number(Member(q, "y"), none),
                             Number(Member(q, "z"), none), Number(Member(q, "w"), none)};
    // The grip points along its y, the bur along its own -z. Checked before it is normalised: what is
    // no turn would become one.
    constexpr double kHalf = std::numbers::sqrt2 / 2;
    out.orientation = grip_in_scene * Quat{kHalf, 0, 0, kHalf};
    const json::value* buttons = Member(state, "buttons");
    out.pedal = IsTrue(Member(state, "button")) || IsTrue(Member(buttons, "a")) ||
                IsTrue(Member(buttons, "button_1"));
    if (!CanBe(out)) return false;
    out.orientation = out.orientation.Normalised();
    return true;
  }

  const std::string profile_;
  const bool has_pedal_;
  const std::string wanted_;  // unit
  const std::unique_ptr<WebSocket> socket_;
  std::string text_, id_, name_, session_;
  bool has_grip_ = false;      // at the beginning
  bool has_position_ = false;  // the newest answer
  size_t form_ = 0;
  int without_position_ = 0, without_grip_ = 0;
};

struct Place {
  std::string host = kHost, port = kPort;
};

// "HOST:PORT", "HOST" or nothing.
Place PlaceOf(const std::string& address) {
  Place out;
  const size_t colon = address.rfind(':');
  if (!address.empty()) out.host = address.substr(0, colon);
  if (colon != address.npos) out.port = address.substr(colon + 1);
  return out;
}

Result<std::unique_ptr<WebSocket>> Connect(const std::string& address) {
  const Place place = PlaceOf(address);
  return WebSocket::Connect(place.host, place.port);
}

}  // namespace

Result<std::unique_ptr<PolledBus>> OpenInverse3(const BusChoice& choice) {
  ENAMEL_ASSIGN_OR_RETURN(auto socket, Connect(choice.address));
  auto bus = std::make_unique<Inverse3>(choice, std::move(socket));
  ENAMEL_RETURN_IF_ERROR(bus->Begin());
  return std::unique_ptr<PolledBus>(std::move(bus));
}

std::vector<SdkDevice> FindInverse3At(const std::string& address) {
  std::vector<SdkDevice> out;
  auto socket = Connect(address);
  if (!socket.ok()) return out;
  const auto inventory = ReadInventory(**socket);
  const json::array* all = inventory.ok() ? List(*inventory, "inverse3") : nullptr;
  if (all == nullptr) return out;
  for (const json::value& device : *all) {
    const std::string type = TypeOf(device);
    out.push_back({"", NameOf(device), ModelNamed(type) == nullptr ? "" : type, "",
                   UnitNamed(Text(Member(&device, "device_id"))),
                   WhyNotUsable(*inventory, device)});
  }
  return out;
}

std::vector<SdkDevice> FindInverse3() { return FindInverse3At({}); }

}  // namespace enamel::station::sdk
