#include <gtest/gtest.h>
#include <poll.h>
#include <pty.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <boost/json.hpp>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <set>
#include <thread>

#include "common/base/file.h"
#include "common/scene/builtin/builtin.h"
#include "common/scene/find_profile.h"
#include "station/app/first_hour/command.h"
#include "station/app/first_hour/hour.h"
#include "station/lab/devices/emulated_inverse3.h"
#include "tests/support/dice.h"
#include "tests/support/json_schema.h"
#include "tests/support/temp_folder.h"

// The first hour with units of this file's own making: a mass with damping and friction, in hands and
// with weights that this file knows. Nothing of the product's simulation is in them.
namespace enamel::station::first_hour {
namespace {

namespace fs = std::filesystem;
namespace json = boost::json;

constexpr double kTick_s = 1e-3, kG_m_per_s2 = 9.80665;

// What is wrong with a unit.
struct Faults {
  dmat3 axes{1};        // of poses: reported = axes * true
  dmat3 force_axes{1};  // of forces: arriving = force_axes * asked
  double arrives = 1;   // share of a force
  double noise_m = 0, drift_m_per_s = 0;
  bool returns = true, opens_again = true;
  double mass_kg = 0.1, damping_n_s_per_m = 2, friction_n = 0.05;
};

// Where the hand and the weights are, and what was seen.
struct World {
  Faults faults;
  bool plugged = true, pedal = false, lies = false;
  double hand_n_per_m = 0;  // 0: hands off
  dvec3 hand_m{0};
  double hung_kg = 0, arm_n = 0.3;
  dvec3 x{0}, v{0}, asked_n{0};
  double most_n = 0;  // ever asked for
  int opened = 0;
};

class Bench final : public Device {
 public:
  explicit Bench(World& world) : w_(world) { ++w_.opened; }
  std::string Name() const override { return "bench"; }
  Hand hand() const override { return MakeHand(HandKind::kHaptic, Name(), "bench", "bench:1"); }
  std::string Unit() const override { return "bench:1"; }
  DeviceCounters counters() const noexcept override { return counters_; }
  void SendForce(const dvec3& force_n) noexcept override {
    w_.asked_n = w_.plugged ? force_n : dvec3(0);
    w_.most_n = std::max(w_.most_n, glm::length(force_n));
    ++counters_.writes;
  }
  DeviceSample ReadSample() noexcept override {
    DeviceSample out;
    if (!w_.plugged) gone_ = true;
    if (!w_.plugged || (gone_ && !w_.faults.returns)) {
      counters_.detached = 1;
      out.attached = out.fresh = false;
      return out;
    }
    for (int i = 0; i < 10; ++i) Move(kTick_s / 10);
    const double drift_m =
        w_.faults.drift_m_per_s * kTick_s * static_cast<double>(counters_.samples);
    const dvec3 at = w_.faults.axes * w_.x + dvec3(drift_m);
    for (int i = 0; i < 3; ++i) {
      out.counts[static_cast<size_t>(i)] =
          static_cast<int32_t>(std::lround((at[i] + Noise()) / kCount_m));
    }
    out.buttons = w_.pedal ? kPedal : 0;
    ++counters_.samples;
    return out;
  }
  static constexpr double kCount_m = 10e-6;

 private:
  // Semi-implicit; friction may stop the mass and no more. The weight hangs on the handle, on a table
  // while it lies.
  void Move(double dt) {
    const Faults& f = w_.faults;
    const double mass = f.mass_kg + w_.hung_kg;
    dvec3 push = f.force_axes * w_.asked_n * f.arrives + (w_.hand_m - w_.x) * w_.hand_n_per_m;
    if (w_.hand_n_per_m > 0) push -= w_.v * 3.0;
    if (w_.lies) {
      push.z -= w_.arm_n + w_.hung_kg * kG_m_per_s2;
      if (w_.x.z < 0) push.z += -5000 * w_.x.z - 20 * w_.v.z;
    }
    for (int i = 0; i < 3; ++i) {
      double v = w_.v[i] + dt / mass * (push[i] - f.damping_n_s_per_m * w_.v[i]);
      const double stop = f.friction_n * dt / mass;
      w_.v[i] = std::fabs(v) <= stop ? 0 : v - std::copysign(stop, v);
    }
    w_.x += w_.v * dt;
  }
  double Noise() {
    double sum = -6;
    for (int i = 0; i < 12; ++i) sum += dice_.Uniform();
    return w_.faults.noise_m * sum;
  }

  World& w_;
  testing_support::Dice dice_{7};
  DeviceCounters counters_;
  bool gone_ = false;
};

// Does what it is asked, unless the test says another thing for a question.
class Helper final : public Person {
 public:
  explicit Helper(World& world) : w_(world) {}
  void Tell(const std::string& text) override { told += text + "\n"; }
  void Ask(const std::string& id, const std::string&) override {
    asked_ = id;
    polls_ = 0;
    answer_ = "";
    if (const auto own = instead.find(id); own != instead.end()) {
      answer_ = own->second;
      return;
    }
    w_.hand_n_per_m = 300;
    w_.lies = false;
    w_.hand_m = dvec3(0);
    if (id == "directions.right.to") w_.hand_m = dvec3(0.05, 0, 0);
    if (id == "directions.away.to") w_.hand_m = dvec3(0, 0.05, 0);
    if (id == "directions.up.to") w_.hand_m = dvec3(0, 0, 0.05);
    if (id.ends_with(".yes") || id == "end.free") answer_ = "yes";
    if (id.starts_with("force.")) w_.hand_n_per_m = 40;
    if (id == "weight.grams") answer_ = "100";
    if (id.starts_with("weight.") && id.ends_with(".yes")) {
      w_.hand_n_per_m = 0;
      w_.lies = true;
      w_.hung_kg = id == "weight.loaded.yes" ? 0.1 : 0;
    } else {
      w_.hung_kg = 0;
    }
    if (id == "delay.yes" || id == "noise.still") {
      w_.hand_n_per_m = 0;
      w_.x = w_.v = dvec3(0);
    }
    if (id == "unplug.plugged") w_.plugged = true;
  }
  Heard Listen(double) override {
    if (const auto closed = closes_at.find(asked_); closed != closes_at.end())
      return {Heard::Kind::kClosed};
    ++polls_;
    if (asked_ == "workspace.end") {
      // Around three circles.
      const double a = polls_ * 2 * M_PI / 1000;
      const int plane = std::min(polls_ / 1000, 2);
      w_.hand_m = dvec3(0);
      w_.hand_m[plane] = 0.09 * std::sin(a);
      w_.hand_m[(plane + 1) % 3] = 0.09 * (1 - std::cos(a)) - 0.09;
    }
    w_.pedal = asked_ == "buttons.end" && polls_ > 100 && polls_ < 200;
    if (polls_ < (asked_ == "workspace.end" ? 3000 : 500)) return {};
    if (asked_ == "unplug.pull") w_.plugged = false;
    return {Heard::Kind::kAnswer, answer_};
  }

  std::map<std::string, std::string> instead;
  std::set<std::string> closes_at;
  std::string told;

 private:
  World& w_;
  std::string asked_, answer_;
  int polls_ = 0;
};

json::object Schema() {
  std::ifstream in(fs::path(ENAMEL_SOURCE_DIR) / "schemas/first_hour.schema.json");
  return json::parse(std::string(std::istreambuf_iterator<char>(in), {})).as_object();
}

// As the command completes what the hour found.
std::string WhyNotOfSchema(json::object document) {
  document["enamel_first_hour"] = 1;
  document["software"] = "test";
  document["began_ms"] = document["ended_ms"] = 0;
  document["rate_hz"] = 1000;
  document["max_force_n"] = 2.0;
  document["libraries"] = json::array();
  document["computer"] = json::object{
      {"kernel", ""}, {"machine", ""}, {"processor", ""}, {"processors", 1}, {"realtime", nullptr}};
  const json::object schema = Schema();
  return test::WhyNotOfSchema(document, schema, schema);
}

class FirstHourTest : public testing::Test {
 protected:
  MeasuredDevice Unit() {
    MeasuredDevice out;
    out.device = std::make_unique<Bench>(world_);
    out.profile = *scene::FindProfile("phantom_desktop");
    out.count_m.fill(Bench::kCount_m);
    return out;
  }
  HourSetup SetupFor(Person& person) {
    HourSetup setup;
    setup.person = &person;
    setup.by_clock = false;
    setup.stop = &stop_;
    setup.keep = [&](const json::object& document) { kept_ = document; };
    setup.open = [&]() -> Result<MeasuredDevice> {
      if (world_.opened > 0 && !world_.faults.opens_again)
        return Status(Code::kUnavailable, "it is nowhere", "not_attached");
      return Unit();
    };
    return setup;
  }
  json::object Run() { return Run(helper_); }
  json::object Run(Person& person) {
    const json::object document = Hour(SetupFor(person)).Run();
    EXPECT_EQ(WhyNotOfSchema(document), "");
    EXPECT_EQ(world_.asked_n, dvec3(0)) << "the motors are left without a force";
    return document;
  }
  // Steps that a test is not about.
  void Skip(std::initializer_list<const char*> questions) {
    for (const char* q : questions) helper_.instead[q] = "skip not in this test";
  }
  static const json::object& Found(const json::object& document, const char* step) {
    return document.at("steps").at(step).at("found").as_object();
  }
  static std::string State(const json::object& document, const char* step) {
    return document.at("steps").at(step).at("state").as_string().c_str();
  }
  static std::set<std::string> Codes(const json::object& document) {
    std::set<std::string> out;
    for (const json::value& p : document.at("problems").as_array())
      out.insert(p.at("code").as_string().c_str());
    return out;
  }
  static std::string Text(const json::object& document, const char* code) {
    for (const json::value& p : document.at("problems").as_array())
      if (p.at("code") == code) return p.at("text").as_string().c_str();
    return "";
  }

  World world_;
  Helper helper_{world_};
  std::atomic<int> stop_{0};
  json::object kept_;
};

TEST_F(FirstHourTest, AGoodUnitGoesThroughAllStepsAndNothingIsWrong) {
  const json::object document = Run();
  EXPECT_TRUE(document.at("complete").as_bool());
  EXPECT_EQ(document.at("ended_by"), "end");
  EXPECT_EQ(Codes(document), std::set<std::string>{}) << json::serialize(document.at("problems"));
  for (const auto& [name, step] : document.at("steps").as_object())
    EXPECT_EQ(step.at("state"), "done") << name << ": " << step.at("reason");
  EXPECT_EQ(document.at("device").at("unit"), "bench:1");
  // Three circles of 90 mm: the table's radius is 100.
  for (const json::value& mm : Found(document, "workspace").at("extent_mm").as_array())
    EXPECT_NEAR(mm.to_number<double>(), 180, 20) << "the hand's spring swings over";
  EXPECT_NEAR(Found(document, "directions").at("length_share").to_number<double>(), 1, 0.02);
  EXPECT_NEAR(Found(document, "weight").at("up").at("scale_percent").to_number<double>(), 100, 2);
  EXPECT_NEAR(Found(document, "weight").at("friction_n").to_number<double>(), 0.05, 0.06);
  EXPECT_NEAR(Found(document, "weight").at("own_weight_n").to_number<double>(), 0.3, 0.03);
  const json::value& z = Found(document, "delay").at("axes").as_array()[2];
  EXPECT_NEAR(z.at("mass_g").at("value").to_number<double>(), 100, 5);
  EXPECT_NEAR(z.at("damping_n_s_per_m").at("value").to_number<double>(), 2, 0.1);
  EXPECT_NEAR(z.at("friction_n").at("value").to_number<double>(), 0.05, 0.01);
  EXPECT_EQ(Found(document, "buttons").at("pedal").at("presses"), 1);
  EXPECT_EQ(Found(document, "unplug").at("noticed_ms").to_number<double>(), 1);
  EXPECT_TRUE(Found(document, "unplug").at("returned").as_bool());
  EXPECT_LE(world_.most_n, 2 * (1 + 1e-12));
  EXPECT_EQ(json::serialize(kept_.at("steps")), json::serialize(document.at("steps")));
}

TEST_F(FirstHourTest, ExchangedAxesAreNamedAndAreMirrored) {
  Skip({"weight.grams", "delay.yes", "unplug.pull"});
  world_.faults.axes = dmat3(dvec3(0, 1, 0), dvec3(1, 0, 0), dvec3(0, 0, 1));
  world_.faults.force_axes = world_.faults.axes;  // as a driver that exchanges both
  const json::object document = Run();
  EXPECT_EQ(Codes(document), std::set<std::string>{"axes"});
  EXPECT_NE(Text(document, "axes").find("right comes as +y, away comes as +x, up comes as +z"),
            std::string::npos)
      << Text(document, "axes");
  EXPECT_NE(Text(document, "axes").find("mirrored"), std::string::npos);
  EXPECT_FALSE(Found(document, "directions").at("right_handed").as_bool());
  // A force goes the way that the driver's own axes say.
  EXPECT_TRUE(Found(document, "force").at("x").at("with_the_force").as_bool());
}

TEST_F(FirstHourTest, AQuarterTurnIsNotMirrored) {
  Skip({"force.x.yes", "weight.grams", "delay.yes", "unplug.pull"});
  world_.faults.axes = dmat3(dvec3(0, 1, 0), dvec3(-1, 0, 0), dvec3(0, 0, 1));
  const json::object document = Run();
  EXPECT_EQ(Codes(document), std::set<std::string>{"axes"});
  EXPECT_TRUE(Found(document, "directions").at("right_handed").as_bool());
  EXPECT_NE(Text(document, "axes").find("away comes as -x"), std::string::npos);
}

TEST_F(FirstHourTest, AForceThatGoesTheOtherWayIsNamed) {
  Skip({"weight.grams", "delay.yes", "unplug.pull"});
  world_.faults.force_axes[1][1] = -1;
  const json::object document = Run();
  EXPECT_EQ(Codes(document), std::set<std::string>{"force_direction"});
  EXPECT_EQ(Text(document, "force_direction"), "a force along +y moved the handle along -y");
}

// m g hangs on the plant; the command is told the grams and sees nothing but counts.
TEST_F(FirstHourTest, AForceScaleThatIsOffIsFoundByTheWeight) {
  Skip({"force.x.yes", "delay.yes", "unplug.pull"});
  for (const double arrives : {0.8, 1.2, 1.5}) {
    world_ = {};
    world_.faults.arrives = arrives;
    const json::object document = Run();
    const json::value& up = Found(document, "weight").at("up");
    EXPECT_NEAR(up.at("scale_percent").to_number<double>(), 100 * arrives, 2);
    EXPECT_LE(up.at("uncertainty_percent").to_number<double>(), 2);
    EXPECT_EQ(Codes(document), std::set<std::string>{"force_scale"}) << arrives;
    EXPECT_NE(Text(document, "force_scale").find(std::to_string(std::lround(100 * arrives)) + " %"),
              std::string::npos)
        << Text(document, "force_scale");
  }
}

TEST_F(FirstHourTest, AWeightThatTheMotorsDoNotLiftIsSaid) {
  Skip({"workspace.end", "force.x.yes", "delay.yes", "unplug.pull"});
  world_.faults.arrives = 0.3;
  const json::object document = Run();
  EXPECT_EQ(State(document, "weight"), "failed");
  EXPECT_EQ(document.at("steps").at("weight").at("reason"),
            "the handle did not rise by 3 mm at 2.00 N");
  EXPECT_TRUE(Found(document, "weight").contains("empty"));
}

TEST_F(FirstHourTest, ANoisyUnitIsNamedWithItsDeviation) {
  Skip({"workspace.end", "force.x.yes", "weight.grams", "delay.yes", "unplug.pull"});
  world_.faults.noise_m = 40e-6;
  const json::object document = Run();
  EXPECT_EQ(Codes(document), std::set<std::string>{"noise"});
  // sqrt(40^2 + 10^2/12): the noise and what the counts add.
  for (const json::value& um : Found(document, "noise").at("deviation_um").as_array())
    EXPECT_NEAR(um.to_number<double>(), 40.1, 2);
  EXPECT_EQ(Found(document, "noise").at("smallest_step_um").as_array()[0].to_number<double>(), 10);
}

TEST_F(FirstHourTest, AUnitThatDriftsAtRestIsNamedAndIsNotTakenForANoisyOne) {
  Skip({"force.x.yes", "weight.grams", "delay.yes", "unplug.pull"});
  world_.faults.drift_m_per_s = 100e-6;
  const json::object document = Run();
  EXPECT_EQ(Codes(document), std::set<std::string>{"drift"});
  for (const json::value& um : Found(document, "noise").at("drift_um").as_array())
    EXPECT_NEAR(um.to_number<double>(), 200, 2);
}

TEST_F(FirstHourTest, OneThatDoesNotComeBackAfterTheCableIsNamedAndOpenedAnew) {
  for (const bool opens : {true, false}) {
    world_ = {};
    Skip({"workspace.end", "force.x.yes", "weight.grams", "delay.yes"});
    world_.faults.returns = false;
    world_.faults.opens_again = opens;
    const json::object document = Run();
    EXPECT_EQ(Codes(document), opens ? std::set<std::string>{"no_return"}
                                     : (std::set<std::string>{"no_return", "open"}));
    const json::object& found = Found(document, "unplug");
    EXPECT_FALSE(found.at("returned").as_bool());
    ASSERT_EQ(found.at("reopened").as_array().size(), 1u);
    EXPECT_EQ(found.at("reopened").as_array()[0].at("ok"), opens);
    EXPECT_EQ(found.at("reopened").as_array()[0].at("cause"), opens ? "" : "not_attached");
    EXPECT_EQ(State(document, "unplug"), opens ? "done" : "failed");
    EXPECT_EQ(found.at("after").at("detached"), 1);
    EXPECT_TRUE(document.at("complete").as_bool());
  }
}

// Somebody beside the helper, who does another thing when something is told, asked or answered.
class Beside final : public Person {
 public:
  explicit Beside(Person& inner) : inner_(inner) {}
  void Tell(const std::string& text) override {
    inner_.Tell(text);
    on_told(text);
  }
  void Ask(const std::string& id, const std::string& text) override {
    inner_.Ask(id, text);
    asked_ = id;
    on_asked(id);
  }
  Heard Listen(double now_s) override {
    const Heard heard = inner_.Listen(now_s);
    if (heard.kind == Heard::Kind::kAnswer) on_answered(asked_);
    return heard;
  }
  std::function<void(const std::string&)> on_told = [](const std::string&) {};
  std::function<void(const std::string&)> on_asked = on_told, on_answered = on_told;

 private:
  Person& inner_;
  std::string asked_;
};

TEST_F(FirstHourTest, NothingButAYesPushes) {
  for (const char* answer : {"", "y", "Yes", "yes please", "no"}) {
    world_ = {};
    stop_ = false;
    helper_.instead["force.x.yes"] = answer;
    Beside patient(helper_);
    int asked = 0;
    patient.on_asked = [&](const std::string&) { stop_ = ++asked == 4; };
    Hour hour(SetupFor(patient));
    hour.rig().Hold(Unit());
    Step step("force");
    EXPECT_TRUE(IsEnd(Force(hour, step))) << answer;
    EXPECT_EQ(asked, 4) << answer;
    EXPECT_EQ(world_.most_n, 0) << answer;
  }
}

TEST_F(FirstHourTest, AHandleThatIsLetGoOfEndsItsPush) {
  world_.faults.mass_kg = 0.02;
  world_.faults.damping_n_s_per_m = 0.01;
  world_.faults.friction_n = 0;
  Beside loose(helper_);
  loose.on_answered = [&](const std::string&) { world_.hand_n_per_m = 0; };
  Hour hour(SetupFor(loose));
  hour.rig().Hold(Unit());
  Step step("force");
  ASSERT_TRUE(Force(hour, step).ok());
  // Free, it is seen to go 15 mm before it is too fast: 0.5 N/s on 20 g take 0.15 s, to 0.3 m/s.
  EXPECT_LE(world_.most_n, 0.1);
  EXPECT_EQ(world_.asked_n, dvec3(0));
}

TEST_F(FirstHourTest, APushEndsAtItsLimitsAndStaysEnded) {
  Hour hour(SetupFor(helper_));
  Rig& rig = hour.rig();
  rig.Hold(Unit());
  const auto push = [&](double damping_n_s_per_m, const char* why) {
    world_.x = world_.v = dvec3(0);
    world_.faults.damping_n_s_per_m = damping_n_s_per_m;
    for (int i = 0; i < 30; ++i) rig.Tick();
    rig.BeginPush({1.5, 0.25, 0.03});
    for (int i = 0; i < 1000 && rig.cut().empty(); ++i) {
      rig.Tick(dvec3(2, 0, 0));
      EXPECT_LE(glm::length(world_.asked_n), 1.5 * (1 + 1e-12));
    }
    EXPECT_EQ(rig.cut(), why);
    rig.Tick(dvec3(2, 0, 0));
    EXPECT_EQ(world_.asked_n, dvec3(0));
  };
  push(0.1, "the handle moved too fast");
  // 15 m/s^2: 0.25 m/s after 17 ms and 2 mm; seen over 20 ms, it is 0.4 m/s at most.
  EXPECT_LE(glm::length(world_.v), 0.45);
  push(20, "the handle moved too far");
  world_.plugged = false;
  push(20, "the unit was unplugged");
}

TEST_F(FirstHourTest, AStopInAPushIsForceZeroInTheSameTickAndKeepsWhatWasFound) {
  Beside stopper(helper_);
  stopper.on_told = [&](const std::string& text) {
    if (text.find("swings along x") != std::string::npos) stop_ = true;
  };
  const json::object document = Run(stopper);
  EXPECT_FALSE(document.at("complete").as_bool());
  EXPECT_EQ(document.at("ended_by"), "the program was asked to stop");
  EXPECT_EQ(State(document, "weight"), "done");
  EXPECT_EQ(State(document, "delay"), "failed");
  EXPECT_EQ(State(document, "noise"), "not_reached");
}

TEST_F(FirstHourTest, AnInputThatEndsKeepsWhatWasFoundAndAStepLeftOutItsReason) {
  helper_.instead["workspace.end"] = "skip the table is too small";
  helper_.instead["directions.right.from"] = "skip";
  helper_.instead["directions.why"] = "no time";
  helper_.closes_at = {"force.y.yes"};
  const json::object document = Run();
  EXPECT_EQ(State(document, "workspace"), "skipped");
  EXPECT_EQ(document.at("steps").at("workspace").at("reason"), "the table is too small");
  EXPECT_EQ(document.at("steps").at("directions").at("reason"), "no time");
  EXPECT_EQ(document.at("ended_by"), "the input ended");
  EXPECT_TRUE(Found(document, "force").contains("x"));
  EXPECT_FALSE(Found(document, "force").contains("y"));
  EXPECT_EQ(State(document, "end"), "not_reached");
}

TEST_F(FirstHourTest, AUnitThatDoesNotOpenIsTriedAgainAndEachCauseIsKept) {
  int tries = 0;
  HourSetup setup = SetupFor(helper_);
  setup.open = [&]() -> Result<MeasuredDevice> {
    if (++tries == 3) helper_.instead["start.open"] = "skip it will not";
    return Status(Code::kUnavailable, "put it into its pit", "pit");
  };
  const json::object document = Hour(setup).Run();
  EXPECT_EQ(WhyNotOfSchema(document), "");
  const json::array& attempts = Found(document, "start").at("attempts").as_array();
  ASSERT_EQ(attempts.size(), 3u);
  EXPECT_EQ(attempts[0].at("cause"), "pit");
  EXPECT_EQ(document.at("ended_by"), "no unit was opened");
  EXPECT_EQ(State(document, "end"), "not_reached");
  EXPECT_NE(helper_.told.find("put it into its pit"), std::string::npos);
}

TEST(FirstHourScriptTest, LinesAreReadAndWrongOnesAreNamed) {
  const auto lines =
      ParseScript("# a comment\n\nhoming.did: in the pit: twice\n workspace.end @ 2.5 :\r\n");
  ASSERT_TRUE(lines.ok()) << lines.status().message();
  ASSERT_EQ(lines->size(), 2u);
  EXPECT_EQ((*lines)[0].id, "homing.did");
  EXPECT_EQ((*lines)[0].answer, "in the pit: twice");
  EXPECT_EQ((*lines)[1].id, "workspace.end");
  EXPECT_EQ((*lines)[1].after_s, 2.5);
  for (const char* wrong :
       {"a: b\nnothing", "a: b\nx @late: y", "a: b\nx @-1: y", "a: b\n: y", "a: b\nx @1e9: y"}) {
    const auto refused = ParseScript(wrong);
    ASSERT_FALSE(refused.ok()) << wrong;
    EXPECT_EQ(refused.status().message().find("line 2: "), 0u) << refused.status().message();
  }
  EXPECT_EQ(ParseScript(std::string(70'000, '#')).status().code(), Code::kTooLarge);
}

// Says yes to everything, and hears what it is asked.
class Nodding final : public Person {
 public:
  void Tell(const std::string&) override {}
  void Ask(const std::string& id, const std::string&) override { asked += id + " "; }
  Heard Listen(double) override { return {Heard::Kind::kAnswer, "no"}; }
  std::string asked;
};

TEST(FirstHourScriptTest, AScriptComesInItsTimeAndNeverLetsARealUnitPush) {
  Nodding person;
  const std::vector<ScriptLine> lines = {{"a", 0, "1"}, {"a", 2, "2"}, {"force.x.yes", 0, "yes"}};
  for (const bool consents : {false, true}) {
    Script script(lines, person, consents);
    script.Ask("a", "");
    EXPECT_EQ(script.Listen(10).text, "1");
    script.Ask("a", "");
    EXPECT_EQ(script.Listen(10).kind, Heard::Kind::kNothing);
    EXPECT_EQ(script.Listen(12).text, "2");
    script.Ask("force.x.yes", "");
    EXPECT_EQ(script.Listen(12).text, consents ? "yes" : "no");
    script.Ask("b", "");
    EXPECT_EQ(script.Listen(12).kind, Heard::Kind::kClosed);
  }
}

// In real time, through the driver that the device would have.
TEST(FirstHourOnADriverTest, AnEmulatedInverse3IsReadFeltAndMissed) {
  lab::EmulatedInverse3 service;
  service.Set(dvec3(0, 0.1, 0.1));
  class AtTheChair final : public Person {
   public:
    explicit AtTheChair(lab::EmulatedInverse3& service) : service_(service) {}
    void Tell(const std::string&) override {}
    void Ask(const std::string& id, const std::string&) override {
      asked_ = id;
      since_s_ = -1;
      dvec3 at(0, 0.1, 0.1);
      if (id == "directions.right.to") at.x += 0.05;
      if (id == "directions.away.to") at.y += 0.05;
      if (id == "directions.up.to") at.z += 0.05;
      service_.Set(at);
    }
    Heard Listen(double now_s) override {
      if (since_s_ < 0) since_s_ = now_s;
      const double since = now_s - since_s_;
      if (asked_ == "unplug.plugged") return {Heard::Kind::kClosed};
      service_.Grip({0, 0, 0, 1}, asked_ == "buttons.end" && since > 0.1, false);
      if (since < (asked_ == "buttons.end" ? 0.2 : 0.05)) return {};
      if (asked_ == "unplug.pull") service_.Unplug();
      if (asked_ == "workspace.end" || asked_ == "force.x.yes" || asked_ == "weight.grams" ||
          asked_ == "delay.yes" || asked_ == "noise.still")
        return {Heard::Kind::kAnswer, "skip nobody is here"};
      return {Heard::Kind::kAnswer, ""};
    }

   private:
    lab::EmulatedInverse3& service_;
    std::string asked_;
    double since_s_ = -1;
  } person(service);
  std::atomic<int> stop{0};
  HourSetup setup;
  setup.person = &person;
  setup.stop = &stop;
  setup.open = [&] { return OpenToMeasure(service.choice(), "inverse3", 1000); };
  const json::object document = Hour(setup).Run();
  EXPECT_EQ(WhyNotOfSchema(document), "");
  const json::object& steps = document.at("steps").as_object();
  EXPECT_EQ(document.at("device").at("driver"), "inverse3");
  EXPECT_GT(steps.at("start").at("found").at("first_pose_ms").to_number<double>(), 0);
  EXPECT_TRUE(steps.at("homing").at("found").at("plausible").as_bool());
  EXPECT_TRUE(steps.at("directions").at("found").at("as_expected").as_bool())
      << json::serialize(steps.at("directions"));
  EXPECT_EQ(steps.at("buttons").at("found").at("pedal").at("presses"), 1);
  EXPECT_TRUE(steps.at("unplug").at("found").at("noticed").as_bool());
  // The service closes its port at once; a loop that has to wait for its turn is later.
  EXPECT_GT(steps.at("unplug").at("found").at("noticed_ms").to_number<double>(), 0);
  EXPECT_EQ(document.at("ended_by"), "the input ended");
  EXPECT_EQ(service.told(), (std::array<int, 3>{}));
}

// The program as a person starts it, on a terminal of its own.
class OnATerminal {
 public:
  explicit OnATerminal(const std::vector<std::string>& arguments) {
    std::vector<char*> argv;
    for (const std::string& a : arguments) argv.push_back(const_cast<char*>(a.c_str()));
    argv.push_back(nullptr);
    pid_ = ::forkpty(&terminal_, nullptr, nullptr, nullptr);
    if (pid_ == 0) {
      ::execv(argv[0], argv.data());
      ::_exit(127);
    }
  }
  ~OnATerminal() {
    HangUp();
    if (pid_ > 0) {
      ::kill(pid_, SIGKILL);
      ::waitpid(pid_, nullptr, 0);
    }
  }
  // Waits for the next question, ten seconds at most.
  bool IsAsked() {
    const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(10);
    while (std::chrono::steady_clock::now() < until) {
      if (const size_t at = said_.find("\n> ", seen_); at != std::string::npos) {
        seen_ = at + 3;
        return true;
      }
      Read();
    }
    ADD_FAILURE() << said_;
    return false;
  }
  void Type(const std::string& keys) {
    ASSERT_EQ(::write(terminal_, keys.data(), keys.size()), static_cast<ssize_t>(keys.size()));
  }
  void Signal(int signal) { ::kill(pid_, signal); }
  void HangUp() {
    if (terminal_ >= 0) ::close(terminal_);
    terminal_ = -1;
  }
  // Its exit code, ten seconds at most; -1: it did not end by itself.
  int Ends() {
    int state = 0;
    for (int i = 0; i < 1000; ++i) {
      Read();
      if (::waitpid(pid_, &state, WNOHANG) == pid_) {
        pid_ = -1;
        return WIFEXITED(state) ? WEXITSTATUS(state) : -1;
      }
    }
    return -1;
  }

 private:
  void Read() {
    pollfd output{terminal_, POLLIN, 0};
    char bytes[4096];
    if (::poll(&output, terminal_ >= 0 ? 1 : 0, 10) <= 0) return;
    if (const ssize_t got = ::read(terminal_, bytes, sizeof bytes); got > 0)
      said_.append(bytes, static_cast<size_t>(got));
  }

  pid_t pid_ = -1;
  int terminal_ = -1;
  std::string said_;
  size_t seen_ = 0;
};

TEST(FirstHourProgramTest, CtrlCASignalOrAClosedTerminalInAPushLeavesForceZeroAndTheFile) {
  const test::TempFolder folder;
  const fs::path out = folder.path() / "hour.json";
  const std::function<void(OnATerminal&)> ways[] = {
      [](OnATerminal& t) { t.Type("\x03"); },
      [](OnATerminal& t) { t.Signal(SIGTERM); },
      [](OnATerminal& t) { t.HangUp(); },
  };
  for (const auto& way : ways) {
    fs::remove(out);
    lab::EmulatedInverse3 service;
    service.Set(dvec3(0, 0.1, 0.1));
    OnATerminal program({ENAMEL_STATION_PROGRAM, "first-hour", "--device", service.choice(),
                         "--profile", "inverse3", "--out", out.string()});
    for (const char* line : {"\n", "skip it\n", "skip it\n", "skip it\n"}) {
      ASSERT_TRUE(program.IsAsked());
      program.Type(line);
    }
    ASSERT_TRUE(program.IsAsked());
    EXPECT_EQ(service.told(), (std::array<int, 3>{}));
    program.Type("yes\n");
    bool pushed = false;
    for (int i = 0; i < 5000 && !pushed; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      pushed = service.told() != std::array<int, 3>{};
    }
    ASSERT_TRUE(pushed);
    way(program);
    EXPECT_EQ(program.Ends(), 1);
    EXPECT_EQ(service.told(), (std::array<int, 3>{}));
    const auto read = ReadFile(out);
    ASSERT_TRUE(read.ok());
    const json::object document = json::parse(AsText(*read)).as_object();
    EXPECT_FALSE(document.at("complete").as_bool());
    EXPECT_EQ(document.at("steps").at("homing").at("reason"), "it");
    EXPECT_EQ(document.at("steps").at("force").at("state"), "failed");
    const json::object schema = Schema();
    EXPECT_EQ(test::WhyNotOfSchema(document, schema, schema), "");
  }
}

}  // namespace
}  // namespace enamel::station::first_hour
