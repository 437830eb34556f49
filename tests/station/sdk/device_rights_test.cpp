#include <fcntl.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "station/devices/device_node.h"
#include "station/devices/trouble.h"
#include "station/hid/hid_port.h"
#include "station/hid/open_device.h"
#include "station/sdk/buses.h"
#include "station/sdk/device_file.h"
#include "station/sdk/makers_library.h"
#include "station/sdk/open_sdk_device.h"
#include "tests/station/hid/hid_double.h"
#include "tests/station/sdk/usb_double.h"
#include "tests/support/opens_with.h"
#include "tests/support/temp_folder.h"

namespace enamel::station::sdk {
namespace {

// Lines of a file in station/ops without its comments.
std::vector<std::string> OpsLines(const char* name) {
  std::ifstream in(std::filesystem::path(ENAMEL_SOURCE_DIR) / "station/ops" / name);
  EXPECT_TRUE(in) << name;
  std::vector<std::string> out;
  for (std::string line; std::getline(in, line);) {
    if (const size_t begin = line.find_first_not_of(' '); begin != line.npos && line[begin] != '#')
      out.push_back(line);
  }
  return out;
}

bool AnyHas(const std::vector<std::string>& lines, const std::vector<std::string>& parts) {
  return std::ranges::any_of(lines, [&](const std::string& line) {
    return std::ranges::all_of(
        parts, [&](const std::string& part) { return line.find(part) != line.npos; });
  });
}

// All that a driver opens. Empty where it opens none.
std::vector<DeviceNode> AllNodes() {
  std::vector<DeviceNode> out(hid::kNodes.begin(), hid::kNodes.end());
  for (const std::string& driver : Drivers()) {
    const auto nodes = NodesOf(driver);
    EXPECT_EQ(nodes.empty(), driver == "inverse3") << driver;
    out.insert(out.end(), nodes.begin(), nodes.end());
  }
  return out;
}

TEST(DeviceRightsTest, TheUnitTheRulesAndTheProfileGiveEachDriverItsDeviceFiles) {
  const auto unit = OpsLines("enamel-station.service"), rules = OpsLines("60-enamel.rules"),
             profile = OpsLines("apparmor-enamel-station");
  ASSERT_TRUE(AnyHas(unit, {"DevicePolicy=closed"}));
  for (const DeviceNode& node : AllNodes()) {
    const NodeKind& kind = *node.kind;
    const std::string what = std::string(kind.path) + " " + std::string(node.ids);
    EXPECT_TRUE(AnyHas(unit, {"DeviceAllow=char-" + std::string(kind.allowed) + " rw"})) << what;
    EXPECT_TRUE(AnyHas(profile, {"  " + std::string(kind.path) + "*", " rwk,"})) << what;
    std::vector<std::string> rule{"SUBSYSTEM==\"" + std::string(kind.subsystem) + "\"", "uaccess"};
    const std::string ids(node.ids);
    if (!ids.empty()) rule.push_back("{idVendor}==\"" + ids.substr(0, 4) + "\"");
    if (ids.size() > 5) rule.push_back("{idProduct}==\"" + ids.substr(5));
    EXPECT_TRUE(AnyHas(rules, rule)) << what;
  }
}

template <int kError>
int Fails(const char*, int) {
  errno = kError;
  return -1;
}

TEST(DeviceRightsTest, WhyADeviceFileCannotBeOpenedIsNamedWithTheRemedy) {
  struct Case {
    OpenCall call;
    const char* path;
    const char* field;
    const char* said;
  };
  for (const Case& c :
       {Case{Fails<EACCES>, "/dev/hidraw0", trouble::kPermission,
             "/usr/lib/udev/rules.d/60-enamel.rules"},
        {Fails<EPERM>, "/dev/hidraw0", trouble::kConfined, "'DeviceAllow=char-hidraw rw'"},
        {Fails<EPERM>, "/dev/ttyACM0", trouble::kConfined, "'DeviceAllow=char-ttyACM rw'"},
        {Fails<EPERM>, "/dev/bus/usb/001/002", trouble::kConfined,
         "'DeviceAllow=char-usb_device rw'"},
        {Fails<EPERM>, "/dev/ttyUSB12", trouble::kConfined, "'DeviceAllow=char-ttyUSB rw'"},
        {Fails<EBUSY>, "/dev/ttyACM0", trouble::kInUse, "close the other program"},
        {Fails<ENOENT>, "/dev/ttyACM0", trouble::kNotAttached, "plug the device in"},
        {Fails<ENXIO>, "/dev/ttyACM0", trouble::kNotAttached, "plug the device in"},
        {Fails<EIO>, "/dev/ttyACM0", trouble::kDevice, "plug the device in again"}}) {
    const test::OpensWith call(c.call);
    for (const Status& said : {WhyNotOpenable(c.path), OpenAlone(c.path).status()}) {
      EXPECT_EQ(said.field(), c.field) << said.message();
      EXPECT_NE(said.message().find(c.said), std::string::npos) << said.message();
      EXPECT_NE(said.message().find(c.path), std::string::npos) << said.message();
    }
  }
  EXPECT_TRUE(WhyNotOpenable("/dev/null").ok());
}

TEST(DeviceRightsTest, AUnitThatForbidsTheDeviceIsNamedByEachWayToOpenIt) {
  const test::OpensWith call(Fails<EPERM>);
  testing_support::HidBus::Get().Reset();
  testing_support::ScriptedHid mouse;
  mouse.path = "/dev/hidraw5";
  mouse.vendor = 0x1234;
  mouse.product = 0x0006;
  mouse.may_open = false;
  testing_support::HidBus::Get().Plug(mouse);
  EXPECT_EQ(hid::HidPort::Open(mouse.path).status().field(), trouble::kConfined);
  const auto arms = FindWoodenHaptics();
  ASSERT_EQ(arms.size(), 1u);
  EXPECT_EQ(arms[0].problem.field(), trouble::kConfined) << arms[0].problem.message();
  testing_support::HidBus::Get().Reset();

  testing_support::ScriptedUsb falcon{0x0403, 0xcb48};
  falcon.confined = true;
  testing_support::UsbBus::Get().Plug("1-2", falcon);
  const auto falcons = FindFalcon();
  ASSERT_EQ(falcons.size(), 1u);
  EXPECT_EQ(falcons[0].problem.field(), trouble::kConfined) << falcons[0].problem.message();
  EXPECT_NE(falcons[0].problem.message().find("char-usb_device"), std::string::npos);
  testing_support::UsbBus::Get().Unplug("1-2");
}

// A library says only that it finds no device.
TEST(DeviceRightsTest, ADeviceThatItsLibraryDoesNotOpenIsListedWithTheReasonOfItsFile) {
  const test::TempFolder usb;
  std::filesystem::create_directory(usb.path() / "1-1");
  for (const auto& [name, text] :
       {std::pair{"idVendor", "1451"}, {"idProduct", "0402"}, {"busnum", "1"}, {"devnum", "12"}}) {
    std::ofstream(usb.path() / "1-1" / name) << text << "\n";
  }
  const MakersLibrary::Names names{"Maker", "dhd", {"libx.so", ""}, kForceDimensionNodes, "it"};
  const Status none(Code::kUnavailable, "no device found", trouble::kNotAttached);
  const auto problem = [&](OpenCall open) {
    const test::OpensWith call(open);
    const auto found = NotOpened(names, none, usb.path());
    EXPECT_EQ(found.size(), 1u);
    return found.empty() ? Status::Ok() : found[0].problem;
  };
  const Status confined = problem(Fails<EPERM>);
  EXPECT_EQ(confined.field(), trouble::kConfined);
  EXPECT_NE(confined.message().find("/dev/bus/usb/001/012"), std::string::npos)
      << confined.message();
  EXPECT_EQ(problem(Fails<EACCES>).field(), trouble::kPermission);
  EXPECT_EQ(problem([](const char*, int flags) { return ::open("/dev/null", flags); }).message(),
            "no device found");
}

}  // namespace
}  // namespace enamel::station::sdk
