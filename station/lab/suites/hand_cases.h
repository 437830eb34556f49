#pragma once

#include <functional>
#include <string>
#include <vector>

#include "station/lab/laws/motions.h"
#include "station/lab/suites/findings.h"
#include "station/lab/suites/suites.h"

// The cases of the hand suite, one kind a function. Each case is a device with all of its conditions and
// what fills in a row's figures, so that cases of all kinds run on the same threads. SI units.
namespace enamel::station::lab {

struct HandCase {
  HandRow row;                        // names and conditions; figures are filled in by `run`
  std::function<void(HandRow&)> run;  // deterministic; any thread
};
using HandCases = std::vector<HandCase>;

// Device, rate, Kc and delay of the row, and whether the clause covers them in this lattice.
HandRow RowFor(const DeviceModel& model, double b_n_s_per_m, const std::string& motion,
               const Lattice& lattice, int delay_ticks);

// The figures of the force in the hand.
void SetFelt(const fidelity::FeltFigures& figures, HandRow* row);

// Recorded and generated motions in every grip and tissue, along the axes of space, without delay.
void AddFeltCases(const DeviceModel& model, const std::vector<HandMotion>& motions,
                  const std::vector<double>& tissues, HandCases* out);
// The same motions on turned joints, rounded again, with noise, with a tick of delay: at the model's Kc,
// and at the largest that the clause carries.
void AddReadingCases(const DeviceModel& model, const std::vector<HandMotion>& motions,
                     HandCases* out);
// A steady cut on 24 turned lattices that a driver rounds again, without and with a count of noise.
void AddSteadyCases(const DeviceModel& model, HandCases* out);
// 288 hands that push: six masses, four dampings, three tissues, four forces.
void AddPushCases(const DeviceModel& model, HandCases* out);
// As many in tissue that is cut by load: three hardnesses, four loads.
void AddLoadPushCases(const DeviceModel& model, HandCases* out);
// Lifts with relaxing grips (laws/lift.h).
void AddLiftCases(const DeviceModel& model, HandCases* out);
// First strokes after air, and the way to a first force (laws/approach.h).
void AddApproachCases(const DeviceModel& model, HandCases* out);
// Withdrawals with the product's core (laws/withdrawal.h). `block` outlives the cases.
void AddWithdrawalCases(const DeviceModel& model, const cutting::Volume& block, bool quick,
                        HandCases* out);

// Of the force in the hand: what its error is made of, and in how many seconds of strokes it is felt right.
// Adds rows and their tables. `recorded`: people's motions, at any pace; empty: generated ones.
void AddFeltInHand(SuiteContext& context, const std::vector<HandMotion>& recorded);

}  // namespace enamel::station::lab
