#include "station/hid/foot_pedal.h"

#include <charconv>

namespace enamel::station::hid {
namespace {

bool ParseField(std::string_view field, PedalSettings& out) {
  auto number = [&](std::string_view name, int base, uint8_t& value) {
    if (!field.starts_with(name)) return false;
    std::string_view digits = field.substr(name.size());
    auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value, base);
    return error == std::errc() && end == digits.data() + digits.size() && !digits.empty();
  };
  return number("id=", 10, out.report_id) || number("byte=", 10, out.byte) ||
         number("mask=", 16, out.mask);
}

}  // namespace

Result<PedalSettings> ParsePedal(std::string_view text) {
  PedalSettings out;
  size_t comma = text.find(',');
  ENAMEL_ASSIGN_OR_RETURN(auto match, ParseHidMatch(text.substr(0, comma)));
  out.match = match;
  while (comma != text.npos) {
    text = text.substr(comma + 1);
    comma = text.find(',');
    if (!ParseField(text.substr(0, comma), out) || out.mask == 0) {
      return Status(Code::kInvalidInput,
                    "expected id=0..255, byte=0..255 or mask=01..ff (hexadecimal) after the "
                    "pedal's ids; found '" +
                        std::string(text.substr(0, comma)) + "'",
                    "pedal");
    }
  }
  return out;
}

PedalReading ReadPedal(const PedalSettings& settings, ByteView report) noexcept {
  if (report.size() <= settings.byte) return {};
  // A device with several reports has the pedal in only one of them.
  if (settings.report_id != 0 && report[0] != settings.report_id) return {};
  return {true, (report[settings.byte] & settings.mask) != 0};
}

Result<std::unique_ptr<FootPedal>> FootPedal::Open(const PedalSettings& settings) {
  ENAMEL_ASSIGN_OR_RETURN(auto info, FindHid(settings.match));
  // Tried once here, so that a refusal is reported instead of retried for ever.
  ENAMEL_ASSIGN_OR_RETURN(auto port, HidPort::Open(info.path));
  return std::unique_ptr<FootPedal>(
      new FootPedal(settings, info.name.empty() ? settings.match.Text() : info.name));
}

FootPedal::FootPedal(const PedalSettings& settings, std::string name)
    : settings_(settings), name_(std::move(name)), reader_(settings.match, *this) {}

void FootPedal::OnReport(ByteView report) {
  PedalReading reading = ReadPedal(settings_, report);
  if (!reading.relevant) {
    ++refused_;
    return;
  }
  buttons_ = static_cast<uint8_t>(reading.down ? kPedal : 0);
}

}  // namespace enamel::station::hid
