#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/program/findings.h"
#include "station/sdk/open_sdk_device.h"

namespace enamel::station {

struct DoctorCommand {
  std::filesystem::path data;
  std::string server;  // HOST:PORT when it has moved since enrolment
  bool graphics = true;
  std::set<std::string> own_settings;  // that the chair's file or environment gives
  std::filesystem::path json;
};

using program::Finding;
using program::Verdict;

// Checks everything an attempt needs: enrolment, server with its certificate and clock, disk,
// spool, settings from the server, real-time rights, timer, devices and their delay, graphics. Changes nothing, except that
// it writes a file and removes it again. Waits are bounded: for a server that does not answer, by
// ServerLink::kTimeout to connect, then kSilence.
std::vector<Finding> Examine(const DoctorCommand& options);

// The attached devices, each with the reason why it cannot be used. One that cannot is a failure; a grip
// that is missing is none where a foot pedal is there.
Finding DevicesOf(const std::vector<hid::HidInfo>& attached,
                  const std::vector<sdk::SdkDevice>& driven);

// The delay of attempts on this device beside its profile's. One that answers to forces is opened, asked
// for half a second with force 0, and closed.
Finding DelayOf(const std::filesystem::path& data, const sdk::SdkDevice& device);

// Prints Examine's findings, one a line. Errors: kUnavailable if one failed (warnings are no
// error).
Status Doctor(const DoctorCommand& options);

}  // namespace enamel::station
