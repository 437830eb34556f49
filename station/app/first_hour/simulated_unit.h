#pragma once

#include <memory>

#include "station/app/first_hour/person.h"
#include "station/app/measured_device.h"

// A unit that a profile describes, and a person who does with it what each question of the first hour
// asks. For trying the command out. Its time is the loop's: a tick passes with each ReadSample. Thread
// safety: none.
namespace enamel::station::first_hour {

// What the person does with the unit; both sides have it.
struct Play;

class SimulatedPerson final : public Person {
 public:
  // `answers` gives the words where it is not null; else the person has their own. What is told goes to
  // `shown`.
  SimulatedPerson(Person& shown, Person* answers);
  ~SimulatedPerson() override;

  void Tell(const std::string& text) override { shown_.Tell(text); }
  void Ask(const std::string& id, const std::string& text) override;
  Heard Listen(double now_s) override;

  // The unit of this profile, in the person's hand.
  MeasuredDevice Unit(const scene::DeviceProfile& profile, double tick_s);

 private:
  Person& shown_;
  Person* const answers_;
  const std::shared_ptr<Play> play_;
  std::string answer_;
  double since_s_ = -1, takes_s_ = 0, radius_m_ = 0;
  bool presses_ = false, pulls_ = false;  // at the question that was asked last
};

}  // namespace enamel::station::first_hour
