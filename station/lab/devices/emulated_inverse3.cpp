#include "station/lab/devices/emulated_inverse3.h"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core/buffers_to_string.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/websocket/stream.hpp>
#include <boost/json.hpp>
#include <chrono>
#include <cmath>
#include <map>
#include <set>
#include <thread>

#include "common/base/check.h"

namespace enamel::station::lab {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace json = boost::json;
using asio::ip::tcp;
using Error = boost::system::error_code;

constexpr const char* kId = "049D";
constexpr const char* kOtherId = "0BAD";

// A server's text frame, written here by hand so that it can be cut at any byte.
Bytes FrameOf(const std::string& text) {
  Bytes out{0x81};
  if (text.size() < 126) {
    out.push_back(static_cast<uint8_t>(text.size()));
  } else {
    out.push_back(126);
    out.push_back(static_cast<uint8_t>(text.size() >> 8));
    out.push_back(static_cast<uint8_t>(text.size() & 0xFF));
  }
  out.insert(out.end(), text.begin(), text.end());
  return out;
}

}  // namespace

// Everything but what mutex_ guards belongs to the thread.
struct EmulatedInverse3::Service {
  struct Session {
    explicit Session(tcp::socket socket) : stream(std::move(socket)) {}
    beast::websocket::stream<tcp::socket> stream;
    beast::flat_buffer in;
    asio::steady_timer due{stream.get_executor()};
    bool commands = false;  // it has sent a force
  };

  // `port` 0: any.
  Service(EmulatedInverse3& of, uint16_t port)
      : arm(of), acceptor(context, {asio::ip::address_v4::loopback(), port}) {
    Accept();
    thread = std::thread([this] { context.run(); });
  }

  void Accept() {
    acceptor.async_accept([this](Error error, tcp::socket socket) {
      if (error) return;
      socket.set_option(tcp::no_delay(true));
      auto session = std::make_shared<Session>(std::move(socket));
      session->stream.async_accept([this, session](Error refused) {
        if (refused) return;
        sessions.insert(session);
        std::unique_lock lock(arm.mutex_);
        if (!babble.empty()) return Babble(session);
        Send(*session, FrameOf(json::serialize(Message(*session, true))));
        lock.unlock();
        Read(session);
      });
      Accept();
    });
  }
  // Sends it again and again, and reads nothing.
  void Babble(const std::shared_ptr<Session>& session) {
    asio::async_write(session->stream.next_layer(), asio::buffer(babble),
                      [this, session](Error error, size_t) {
                        if (!error) Babble(session);
                      });
  }
  void Read(const std::shared_ptr<Session>& session) {
    session->stream.async_read(session->in, [this, session](Error error, size_t) {
      if (error) {
        sessions.erase(session);
        return;
      }
      const json::value message = json::parse(beast::buffers_to_string(session->in.data()));
      session->in.consume(session->in.size());
      const auto answer = [this, session, message](Error ended) {
        if (ended) return;
        Answer(*session, message);
        Read(session);
      };
      const std::chrono::microseconds late = arm.Wait();
      if (late.count() == 0) return answer({});
      session->due.expires_after(late);
      session->due.async_wait(answer);
    });
  }
  // As on the wire: bytes that the peer no longer takes are lost.
  static void Send(Session& session, const Bytes& bytes) {
    Error error;
    asio::write(session.stream.next_layer(), asio::buffer(bytes), error);
  }

  void Answer(Session& session, const json::value& message) {
    std::lock_guard lock(arm.mutex_);
    ++arm.requests_;
    const json::value& device = message.at("inverse3").at(0);
    bool takes = false;
    if (device.at("device_id").as_string() == id) {
      const json::object& force = device.at("commands").at("set_cursor_force").as_object();
      if (const json::value* f = force.if_contains(form)) {
        takes = session.commands = true;
        const auto mn = [&](const char* axis) {
          return static_cast<int>(std::lround(f->at(axis).to_number<double>() * 1e3));
        };
        arm.told_ = {mn("x"), mn("y"), mn("z")};
      }
    }
    Bytes answer = truncated ? FrameOf("{\"inverse3\":")
                             : FrameOf(json::serialize(Message(session, false, takes)));
    Send(session, arm.Through(std::move(answer)));
  }

  json::value Message(const Session& session, bool full, bool position = false) const {
    json::object state{{"control_domain", "cartesian"},
                       {"control_mode", position ? "cursor_force" : "idle"}};
    if (position) {
      state["cursor_position"] = {{"x", tip_m.x}, {"y", tip_m.y}, {"z", tip_m.z}};
      state["cursor_velocity"] = {{"x", 0.0}, {"y", 0.0}, {"z", 0.0}};
    }
    json::object is;
    for (const auto& [member, value] : status) is[member] = value;
    is["in_use"] = std::any_of(sessions.begin(), sessions.end(), [&](const auto& other) {
      return other.get() != &session && other->commands;
    });
    json::object device{{"device_id", id}, {"state", state}, {"status", is}};
    if (full) {
      device["config"] = {
          {"type", type},
          {"filters", {{"force_gate", {{"gain", 0.3}}}, {"damping", {{"scalar", damping}}}}}};
    }
    json::object out{{"session_id", session_id}, {"inverse3", json::array{}}};
    json::array& listed = out["inverse3"].as_array();
    if (other_first) {
      listed.push_back(device);
      listed.back().as_object()["device_id"] = kOtherId;
    }
    if (connected) listed.push_back(std::move(device));
    const json::value q{{"x", grip[0]}, {"y", grip[1]}, {"z", grip[2]}, {"w", grip[3]}};
    json::object held{{"orientation", q}};
    if (wireless) {
      held["buttons"] = {{"a", button}, {"b", false}, {"c", false}};
    } else {
      held["button"] = button;
    }
    const json::value one{{"device_id", "61548"}, {"state", std::move(held)}};
    out["verse_grip"] = gripped && !wireless && !built ? json::array{one} : json::array{};
    out["wireless_verse_grip"] = gripped && wireless && !built ? json::array{one} : json::array{};
    if (gripped && built) out["custom_verse_grip"] = json::array{one};
    return out;
  }

  EmulatedInverse3& arm;
  asio::io_context context{1};
  tcp::acceptor acceptor;
  std::set<std::shared_ptr<Session>> sessions;
  std::thread thread;

  // Guarded by arm.mutex_.
  dvec3 tip_m{0, 0.15, 0.1};
  std::array<double, 4> grip{-std::sqrt(0.5), 0, 0, std::sqrt(0.5)};  // points down
  bool button = false, wireless = false, truncated = false, connected = true, gripped = true,
       built = false, other_first = false;
  Bytes babble;
  std::string type = "inverse3", id = kId, form = "vector", session_id = "1";
  std::map<std::string, bool> status{{"calibrated", true}, {"power_supply", true}, {"ready", true}};
  double damping = 0;
};

EmulatedInverse3::EmulatedInverse3() : service_(std::make_unique<Service>(*this, 0)) {
  port_ = service_->acceptor.local_endpoint().port();
}

EmulatedInverse3::~EmulatedInverse3() { Unplug(); }

void EmulatedInverse3::Unplug() {
  service_->context.stop();
  if (service_->thread.joinable()) service_->thread.join();
  Error ignored;
  service_->acceptor.close(ignored);
  for (const auto& session : service_->sessions) session->stream.next_layer().close(ignored);
}

void EmulatedInverse3::Plug() {
  auto again = std::make_unique<Service>(*this, port_);
  std::lock_guard lock(mutex_);
  again->tip_m = service_->tip_m;
  service_ = std::move(again);
}

bool EmulatedInverse3::PlugOther() {
  Plug();
  std::lock_guard lock(mutex_);
  service_->id = kOtherId;
  return true;
}

void EmulatedInverse3::Lower(int steps) { Set({0, 0.15, 0.1 - 40e-6 * steps}); }

void EmulatedInverse3::Set(const dvec3& tip_m) {
  std::lock_guard lock(mutex_);
  service_->tip_m = tip_m;
}

void EmulatedInverse3::Grip(const std::array<double, 4>& xyzw, bool button, bool wireless) {
  std::lock_guard lock(mutex_);
  service_->grip = xyzw;
  service_->button = button;
  service_->wireless = wireless;
}

void EmulatedInverse3::Take(const std::string& form) {
  std::lock_guard lock(mutex_);
  service_->form = form;
}

void EmulatedInverse3::Status(const std::string& member, bool value) {
  std::lock_guard lock(mutex_);
  service_->status[member] = value;
}

void EmulatedInverse3::Damp(double scalar) {
  std::lock_guard lock(mutex_);
  service_->damping = scalar;
}

void EmulatedInverse3::Restart() {
  std::lock_guard lock(mutex_);
  service_->session_id = "2";
}

void EmulatedInverse3::Truncate(bool truncate) {
  std::lock_guard lock(mutex_);
  service_->truncated = truncate;
}

void EmulatedInverse3::HasGrip(bool has) {
  std::lock_guard lock(mutex_);
  service_->gripped = has;
}

void EmulatedInverse3::IsOf(const std::string& type) {
  std::lock_guard lock(mutex_);
  service_->type = type;
}

void EmulatedInverse3::HasBuiltGrip() {
  std::lock_guard lock(mutex_);
  service_->built = true;
}

void EmulatedInverse3::Babble(const Bytes& bytes) {
  std::lock_guard lock(mutex_);
  service_->babble = bytes;
}

void EmulatedInverse3::ListOtherFirst() {
  std::lock_guard lock(mutex_);
  service_->other_first = true;
}

void EmulatedInverse3::Disconnect() {
  std::lock_guard lock(mutex_);
  service_->connected = false;
}

}  // namespace enamel::station::lab
