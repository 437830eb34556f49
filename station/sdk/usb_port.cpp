#include "station/sdk/usb_port.h"

#include <libusb-1.0/libusb.h>

#include <algorithm>
#include <array>
#include <cstdio>

#include "station/devices/device_node.h"
#include "station/devices/trouble.h"

namespace enamel::station::sdk {
namespace {

using Clock = std::chrono::steady_clock;

constexpr unsigned kRequest_ms = 1'000, kWrite_ms = 20;
constexpr uint8_t kToDeviceVendor = 0x40;  // bmRequestType
constexpr int kInterface = 0;

struct Context {
  // Stays null where the system has no USB.
  Context() { (void)libusb_init(&context); }
  ~Context() {
    if (context != nullptr) libusb_exit(context);
  }
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;
  libusb_context* context = nullptr;
};

std::string PlaceOf(libusb_device* device) {
  std::array<uint8_t, 7> ports{};
  const int depth = libusb_get_port_numbers(device, ports.data(), static_cast<int>(ports.size()));
  std::string out = std::to_string(libusb_get_bus_number(device));
  for (int i = 0; i < depth; ++i) {
    out += (i == 0 ? '-' : '.') + std::to_string(ports[static_cast<size_t>(i)]);
  }
  return out;
}

std::string NodeOf(libusb_device* device) {
  char path[32];
  std::snprintf(path, sizeof path, "/dev/bus/usb/%03d/%03d", libusb_get_bus_number(device),
                libusb_get_device_address(device));
  return path;
}

// Calls `take` for each attached device until it returns true.
template <typename Take>
void ForEach(libusb_context* context, Take take) {
  if (context == nullptr) return;
  libusb_device** all = nullptr;
  const ssize_t count = libusb_get_device_list(context, &all);
  for (ssize_t i = 0; i < count; ++i) {
    libusb_device_descriptor about{};
    if (libusb_get_device_descriptor(all[i], &about) != LIBUSB_SUCCESS) continue;
    if (take(all[i], UsbInfo{about.idVendor, about.idProduct, PlaceOf(all[i]), NodeOf(all[i])}))
      break;
  }
  if (count >= 0) libusb_free_device_list(all, 1);
}

Status Refused(const UsbInfo& info, int error) {
  const std::string name = "USB socket " + info.place;
  switch (error) {
    case LIBUSB_ERROR_ACCESS:
      return {Code::kUnavailable,
              name +
                  " may not be used by you: /usr/lib/udev/rules.d/60-enamel.rules gives it to the "
                  "group plugdev and to whoever sits here; plug it in again",
              trouble::kPermission};
    case LIBUSB_ERROR_BUSY:
      return {Code::kUnavailable,
              name + " is in use: close the other program or window that uses this device",
              trouble::kInUse};
    case LIBUSB_ERROR_IO:
      // libusb says only this of what a unit's device controller refuses.
      ENAMEL_RETURN_IF_ERROR(WhyNotOpenable(info.node));
      [[fallthrough]];
    default:
      return {
          Code::kUnavailable,
          "cannot open " + name + " (" + libusb_error_name(error) + "): plug the device in again",
          trouble::kNotAttached};
  }
}

}  // namespace

struct UsbPort::Handles {
  ~Handles() {
    if (transfer != nullptr) {
      if (submitted) {
        libusb_cancel_transfer(transfer);
        while (done == 0 && libusb_handle_events_completed(usb.context, &done) == LIBUSB_SUCCESS) {
        }
      }
      libusb_free_transfer(transfer);
    }
    if (device == nullptr) return;
    libusb_release_interface(device, kInterface);
    libusb_close(device);
  }
  // Always one read is under way, so that nothing waits in the device.
  bool Submit() {
    done = 0;
    submitted = libusb_submit_transfer(transfer) == LIBUSB_SUCCESS;
    return submitted;
  }

  Context usb;
  libusb_device_handle* device = nullptr;
  libusb_transfer* transfer = nullptr;
  uint8_t out = 0;
  std::array<uint8_t, kPacketBytes> packet{};
  bool submitted = false;
  int done = 0;
};

std::vector<UsbInfo> ListUsb(uint16_t vendor, uint16_t product) {
  std::vector<UsbInfo> out;
  const Context usb;
  ForEach(usb.context, [&](libusb_device*, const UsbInfo& info) {
    if (info.vendor == vendor && info.product == product) out.push_back(info);
    return false;
  });
  std::ranges::sort(out, {}, &UsbInfo::place);
  return out;
}

Result<std::unique_ptr<UsbPort>> UsbPort::Open(const UsbInfo& info, uint8_t in, uint8_t out) {
  auto handles = std::make_unique<Handles>();
  int error = LIBUSB_ERROR_NO_DEVICE;
  ForEach(handles->usb.context, [&](libusb_device* device, const UsbInfo& found) {
    if (found.place != info.place || found.vendor != info.vendor || found.product != info.product)
      return false;
    error = libusb_open(device, &handles->device);
    return true;
  });
  if (error != LIBUSB_SUCCESS) return Refused(info, error);
  // Where the system cannot do that, it has no driver for the device either.
  libusb_set_auto_detach_kernel_driver(handles->device, 1);
  error = libusb_claim_interface(handles->device, kInterface);
  if (error != LIBUSB_SUCCESS) return Refused(info, error);
  handles->transfer = libusb_alloc_transfer(0);
  if (handles->transfer == nullptr) return Refused(info, LIBUSB_ERROR_NO_MEM);
  libusb_fill_bulk_transfer(
      handles->transfer, handles->device, in, handles->packet.data(), kPacketBytes,
      [](libusb_transfer* transfer) { *static_cast<int*>(transfer->user_data) = 1; },
      &handles->done, 0);
  handles->out = out;
  if (!handles->Submit()) return Refused(info, LIBUSB_ERROR_IO);
  return std::unique_ptr<UsbPort>(new UsbPort(std::move(handles)));
}

UsbPort::UsbPort(std::unique_ptr<Handles> handles) : handles_(std::move(handles)) {}
UsbPort::~UsbPort() = default;

bool UsbPort::Control(uint8_t request, uint16_t value) {
  return libusb_control_transfer(handles_->device, kToDeviceVendor, request, value, kInterface,
                                 nullptr, 0, kRequest_ms) >= 0;
}

bool UsbPort::Write(ByteView bytes) {
  int moved = 0;
  // libusb takes no const bytes, and does not write to them.
  const int error =
      libusb_bulk_transfer(handles_->device, handles_->out, const_cast<uint8_t*>(bytes.data()),
                           static_cast<int>(bytes.size()), &moved, kWrite_ms);
  return error == LIBUSB_SUCCESS || error == LIBUSB_ERROR_TIMEOUT;
}

int UsbPort::Read(std::span<uint8_t> out, std::chrono::microseconds patience) {
  Handles& h = *handles_;
  if (!h.submitted) return -1;
  const auto until = Clock::now() + patience;
  do {
    const auto left = std::chrono::duration_cast<std::chrono::microseconds>(until - Clock::now());
    constexpr int64_t kUsPerSecond = 1'000'000;
    const int64_t us = std::max<int64_t>(left.count(), 0);
    timeval wait{us / kUsPerSecond, us % kUsPerSecond};
    const int error = libusb_handle_events_timeout_completed(h.usb.context, &wait, &h.done);
    if (error != LIBUSB_SUCCESS && error != LIBUSB_ERROR_INTERRUPTED) return -1;
  } while (h.done == 0 && Clock::now() < until);
  if (h.done == 0) return 0;
  h.submitted = false;
  if (h.transfer->status != LIBUSB_TRANSFER_COMPLETED) return -1;
  const size_t size = std::min(static_cast<size_t>(h.transfer->actual_length), out.size());
  std::copy_n(h.packet.begin(), size, out.begin());
  h.Submit();  // one that is refused: the next Read finds the device detached
  return static_cast<int>(size);
}

}  // namespace enamel::station::sdk
