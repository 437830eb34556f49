#include "tests/station/sdk/usb_double.h"

#include <libusb-1.0/libusb.h>

#include <algorithm>
#include <chrono>
#include <vector>

namespace enamel::station::testing_support {

UsbBus& UsbBus::Get() {
  static UsbBus bus;
  return bus;
}

UsbBus::Socket* UsbBus::At(const std::string& place) {
  const auto found = sockets_.find(place);
  return found == sockets_.end() ? nullptr : &found->second;
}

void UsbBus::Plug(const std::string& place, ScriptedUsb device) {
  std::lock_guard lock(mutex);
  sockets_[place] = {std::move(device), false, {}};
}

void UsbBus::Unplug(const std::string& place) {
  std::lock_guard lock(mutex);
  sockets_.erase(place);
  changed.notify_all();
}

void UsbBus::Send(const std::string& place, Bytes packet) {
  constexpr size_t kMaxKept = 16;
  std::lock_guard lock(mutex);
  Socket* socket = At(place);
  if (socket == nullptr || socket->packets.size() >= kMaxKept) return;
  socket->packets.push_back(std::move(packet));
  changed.notify_all();
}

size_t UsbBus::Waiting(const std::string& place) {
  std::lock_guard lock(mutex);
  Socket* socket = At(place);
  return socket == nullptr ? 0 : socket->packets.size();
}

}  // namespace enamel::station::testing_support

// --- libusb.h's functions, as far as the station calls them ---

using enamel::station::testing_support::UsbBus;

struct libusb_context {
  std::vector<libusb_transfer*> submitted;
  bool cancelled = false;
};
struct libusb_device {
  libusb_context* context;
  std::string place;
  uint16_t vendor, product;
};
struct libusb_device_handle {
  libusb_context* context;
  std::string place;
  bool claimed = false;
};

namespace {

// Those that are ready, with the bus locked.
std::vector<libusb_transfer*> TakeReady(libusb_context* context) {
  std::vector<libusb_transfer*> out;
  std::erase_if(context->submitted, [&](libusb_transfer* transfer) {
    UsbBus::Socket* socket = UsbBus::Get().At(transfer->dev_handle->place);
    if (context->cancelled) {
      transfer->status = LIBUSB_TRANSFER_CANCELLED;
    } else if (socket == nullptr) {
      transfer->status = LIBUSB_TRANSFER_NO_DEVICE;
    } else if (!socket->packets.empty()) {
      const enamel::Bytes packet = std::move(socket->packets.front());
      socket->packets.pop_front();
      transfer->actual_length = std::min(static_cast<int>(packet.size()), transfer->length);
      std::copy_n(packet.begin(), transfer->actual_length, transfer->buffer);
      transfer->status = LIBUSB_TRANSFER_COMPLETED;
    } else if (const enamel::Bytes& endless = socket->device.endless; !endless.empty()) {
      transfer->actual_length = std::min(static_cast<int>(endless.size()), transfer->length);
      std::copy_n(endless.begin(), transfer->actual_length, transfer->buffer);
      transfer->status = LIBUSB_TRANSFER_COMPLETED;
    } else {
      return false;
    }
    out.push_back(transfer);
    return true;
  });
  return out;
}

}  // namespace

extern "C" {

int libusb_init(libusb_context** context) {
  *context = new libusb_context;
  return LIBUSB_SUCCESS;
}
void libusb_exit(libusb_context* context) { delete context; }

ssize_t libusb_get_device_list(libusb_context* context, libusb_device*** list) {
  std::lock_guard lock(UsbBus::Get().mutex);
  const auto& sockets = UsbBus::Get().sockets();
  *list = new libusb_device*[sockets.size() + 1]();
  ssize_t count = 0;
  for (const auto& [place, socket] : sockets) {
    (*list)[count++] =
        new libusb_device{context, place, socket.device.vendor, socket.device.product};
  }
  return count;
}
void libusb_free_device_list(libusb_device** list, int) {
  for (libusb_device** device = list; *device != nullptr; ++device) delete *device;
  delete[] list;
}
int libusb_get_device_descriptor(libusb_device* device, libusb_device_descriptor* out) {
  out->idVendor = device->vendor;
  out->idProduct = device->product;
  return LIBUSB_SUCCESS;
}
uint8_t libusb_get_bus_number(libusb_device* device) {
  return static_cast<uint8_t>(std::stoi(device->place));
}
uint8_t libusb_get_device_address(libusb_device*) { return 1; }
int libusb_get_port_numbers(libusb_device* device, uint8_t* ports, int) {
  ports[0] = static_cast<uint8_t>(std::stoi(device->place.substr(device->place.find('-') + 1)));
  return 1;
}

int libusb_open(libusb_device* device, libusb_device_handle** handle) {
  std::lock_guard lock(UsbBus::Get().mutex);
  UsbBus::Socket* socket = UsbBus::Get().At(device->place);
  if (socket == nullptr) return LIBUSB_ERROR_NO_DEVICE;
  if (!socket->device.may_open) return LIBUSB_ERROR_ACCESS;
  if (socket->device.confined) return LIBUSB_ERROR_IO;
  *handle = new libusb_device_handle{device->context, device->place};
  return LIBUSB_SUCCESS;
}
void libusb_close(libusb_device_handle* handle) { delete handle; }
int libusb_set_auto_detach_kernel_driver(libusb_device_handle*, int) { return LIBUSB_SUCCESS; }
int libusb_claim_interface(libusb_device_handle* handle, int) {
  std::lock_guard lock(UsbBus::Get().mutex);
  UsbBus::Socket* socket = UsbBus::Get().At(handle->place);
  if (socket == nullptr) return LIBUSB_ERROR_NO_DEVICE;
  if (socket->claimed) return LIBUSB_ERROR_BUSY;
  socket->claimed = handle->claimed = true;
  return LIBUSB_SUCCESS;
}
int libusb_release_interface(libusb_device_handle* handle, int) {
  std::lock_guard lock(UsbBus::Get().mutex);
  if (!handle->claimed) return LIBUSB_ERROR_NOT_FOUND;
  handle->claimed = false;
  if (UsbBus::Socket* socket = UsbBus::Get().At(handle->place)) socket->claimed = false;
  return LIBUSB_SUCCESS;
}

int libusb_control_transfer(libusb_device_handle* handle, uint8_t, uint8_t request, uint16_t value,
                            uint16_t, unsigned char*, uint16_t, unsigned) {
  std::lock_guard lock(UsbBus::Get().mutex);
  UsbBus::Socket* socket = UsbBus::Get().At(handle->place);
  if (socket == nullptr) return LIBUSB_ERROR_NO_DEVICE;
  if (socket->device.control(request, value)) socket->packets.clear();
  return 0;
}
int libusb_bulk_transfer(libusb_device_handle* handle, unsigned char, unsigned char* data, int size,
                         int* moved, unsigned) {
  std::lock_guard lock(UsbBus::Get().mutex);
  UsbBus::Socket* socket = UsbBus::Get().At(handle->place);
  if (socket == nullptr) return LIBUSB_ERROR_NO_DEVICE;
  socket->device.written({data, static_cast<size_t>(size)});
  *moved = size;
  return LIBUSB_SUCCESS;
}

libusb_transfer* libusb_alloc_transfer(int) { return new libusb_transfer(); }
void libusb_free_transfer(libusb_transfer* transfer) { delete transfer; }
int libusb_submit_transfer(libusb_transfer* transfer) {
  std::lock_guard lock(UsbBus::Get().mutex);
  if (UsbBus::Get().At(transfer->dev_handle->place) == nullptr) return LIBUSB_ERROR_NO_DEVICE;
  transfer->dev_handle->context->submitted.push_back(transfer);
  return LIBUSB_SUCCESS;
}
int libusb_cancel_transfer(libusb_transfer* transfer) {
  std::lock_guard lock(UsbBus::Get().mutex);
  transfer->dev_handle->context->cancelled = true;
  return LIBUSB_SUCCESS;
}
int libusb_handle_events_timeout_completed(libusb_context* context, timeval* wait, int* completed) {
  std::vector<libusb_transfer*> ready;
  {
    std::unique_lock lock(UsbBus::Get().mutex);
    if (*completed != 0) return LIBUSB_SUCCESS;
    UsbBus::Get().changed.wait_for(
        lock, std::chrono::seconds(wait->tv_sec) + std::chrono::microseconds(wait->tv_usec), [&] {
          ready = TakeReady(context);
          return !ready.empty();
        });
  }
  for (libusb_transfer* transfer : ready) transfer->callback(transfer);
  return LIBUSB_SUCCESS;
}
int libusb_handle_events_completed(libusb_context* context, int* completed) {
  timeval minute{60, 0};
  return libusb_handle_events_timeout_completed(context, &minute, completed);
}

const char* libusb_error_name(int) { return "LIBUSB_ERROR"; }

}  // extern "C"
