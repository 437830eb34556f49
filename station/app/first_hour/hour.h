#pragma once

#include <atomic>
#include <boost/json/object.hpp>
#include <functional>
#include <string>

#include "station/app/first_hour/person.h"
#include "station/app/first_hour/rig.h"
#include "station/devices/calibrator.h"

// The first hour with a unit: steps that a person goes through with it, and the document of what was
// found (schemas/first_hour.schema.json). Thread safety: none. Real-time: not safe.
namespace enamel::station::first_hour {

struct HourSetup {
  Person* person = nullptr;
  std::function<Result<MeasuredDevice>()> open;
  bool by_clock = true;  // false: a tick takes no time (simulated)
  double tick_s = 1e-3;
  double max_force_n = 2;
  // Set by a signal: the run ends, with what was found so far.
  const std::atomic<int>* stop = nullptr;
  // Called with the whole document after each step.
  std::function<void(const boost::json::object&)> keep = [](const boost::json::object&) {};
};

// A step's part of the document.
class Step {
 public:
  explicit Step(std::string name) : name_(std::move(name)) {}
  const std::string& name() const { return name_; }
  // Something that is not as it should be; `code` is one of the schema's.
  void Problem(const char* code, const std::string& text);

  boost::json::object found;
  boost::json::array asked, problems;

 private:
  const std::string name_;
};

// What the steps share. A step returns Ok when it is done; the Status of an Ask when the person skipped
// it or the run is over; any other Status when it failed.
class Hour {
 public:
  explicit Hour(const HourSetup& setup);

  // All steps; the document but for what the caller knows of program and computer.
  boost::json::object Run();

  const HourSetup& setup() const { return setup_; }
  Rig& rig() { return rig_; }
  void Tell(const std::string& text) { setup_.person->Tell(text); }
  // Asks, and ticks without force until the answer. `each` is called after every tick. Errors: those that
  // IsSkip and IsEnd tell.
  Result<std::string> Ask(Step& step, const std::string& id, const std::string& text,
                          const std::function<void()>& each = {});
  // Asks for a yes; `most_n` is what the motors will push with. Ok only after one.
  Status AskToPush(Step& step, const std::string& id, const std::string& text, double most_n);
  // Ticks without force. Errors: IsEnd.
  Status Wait(double seconds, const std::function<void()>& each = {});
  // Mean place over a quarter of a second.
  Result<dvec3> Place();
  // The most that a push may use: the person's limit, and the unit's.
  double MostForce_n() const;
  // Ok while the unit is there and sends its pose.
  Status UnitIsThere() const;
  Status OpenUnit(boost::json::object& attempt);

 private:
  Result<std::string> Listen(Step& step, const std::string& id, const std::function<void()>& each);
  void NoteUnit();

  const HourSetup setup_;
  Rig rig_;
  boost::json::object document_;
};

// A step that cannot be done on this unit, or that the person skipped; the message is the reason.
Status Skipped(const std::string& reason);
bool IsSkip(const Status& status);
// The run is over: asked to stop, the input ended, or nobody answered.
bool IsEnd(const Status& status);

// The steps, in the order of the run.
Status Start(Hour& hour, Step& step);
Status Homing(Hour& hour, Step& step);
Status Workspace(Hour& hour, Step& step);
Status Directions(Hour& hour, Step& step);
Status Force(Hour& hour, Step& step);
Status Weight(Hour& hour, Step& step);
Status Delay(Hour& hour, Step& step);
Status Noise(Hour& hour, Step& step);
Status Buttons(Hour& hour, Step& step);
Status Unplug(Hour& hour, Step& step);
Status End(Hour& hour, Step& step);

// To `digits` behind the point.
double Rounded(double v, int digits);
boost::json::array Rounded(const dvec3& v, int digits);
// "+x" for a way most of which goes along +x; empty when no axis has `least` of its length.
std::string AxisOf(const dvec3& way, double least = 0.7);
boost::json::object CountersOf(const Device& device);

}  // namespace enamel::station::first_hour
