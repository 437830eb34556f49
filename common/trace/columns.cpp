#include "common/trace/columns.h"

#include <array>
#include <limits>
#include <string>
#include <type_traits>

namespace enamel::trace {
namespace {

// The values, their first, second and third differences. Part of the format: more is refused.
constexpr int kMaxOrder = 3;

using Values = std::array<uint64_t, kMaxTicksPerChunk>;

// One column: how a field is read from a tick, and put back. `set` is false when the value does not
// fit the field.
struct Column {
  const char* name;
  int64_t (*get)(const Tick&);
  bool (*set)(Tick&, int64_t);
};

template <typename T>
bool Assign(T& field, int64_t value) {
  if (value < std::numeric_limits<T>::min() || value > std::numeric_limits<T>::max()) return false;
  field = static_cast<T>(value);
  return true;
}

template <auto kGroup, auto kField, size_t kAxis>
constexpr Column Axis(const char* name) {
  return {name, [](const Tick& t) -> int64_t { return (t.*kGroup.*kField)[kAxis]; },
          [](Tick& t, int64_t v) { return Assign((t.*kGroup.*kField)[kAxis], v); }};
}

template <auto kGroup, auto kField>
constexpr Column Scalar(const char* name) {
  return {name, [](const Tick& t) -> int64_t { return t.*kGroup.*kField; },
          [](Tick& t, int64_t v) { return Assign(t.*kGroup.*kField, v); }};
}

// Computed force as its difference to the sent one, which is in an earlier column. 0 except where a
// bound or a touch cue has changed the force: a column of zeros.
template <size_t kAxis>
constexpr Column ComputedForce(const char* name) {
  return {name,
          [](const Tick& t) -> int64_t {
            return int64_t{t.witness.force_computed_mn[kAxis]} - t.witness.force_sent_mn[kAxis];
          },
          [](Tick& t, int64_t v) {
            // No difference of two 32-bit numbers is more; the sum below must not overflow.
            constexpr int64_t kWidest = int64_t{1} << 32;
            if (v < -kWidest || v > kWidest) return false;
            return Assign(t.witness.force_computed_mn[kAxis], v + t.witness.force_sent_mn[kAxis]);
          }};
}

using core::TickInput;
using core::TickWitness;

constexpr std::array<Column, kColumnCount> kColumns = {{
    Axis<&Tick::input, &TickInput::counts, 0>("counts x"),
    Axis<&Tick::input, &TickInput::counts, 1>("counts y"),
    Axis<&Tick::input, &TickInput::counts, 2>("counts z"),
    Axis<&Tick::input, &TickInput::orientation, 0>("orientation x"),
    Axis<&Tick::input, &TickInput::orientation, 1>("orientation y"),
    Axis<&Tick::input, &TickInput::orientation, 2>("orientation z"),
    Axis<&Tick::input, &TickInput::orientation, 3>("orientation w"),
    Scalar<&Tick::input, &TickInput::flags>("input flags"),
    Scalar<&Tick::input, &TickInput::bur_speed_krpm>("bur speed"),
    Scalar<&Tick::input, &TickInput::gap_ticks>("gap ticks"),
    Axis<&Tick::witness, &TickWitness::anchor_100nm, 0>("anchor x"),
    Axis<&Tick::witness, &TickWitness::anchor_100nm, 1>("anchor y"),
    Axis<&Tick::witness, &TickWitness::anchor_100nm, 2>("anchor z"),
    Axis<&Tick::witness, &TickWitness::force_sent_mn, 0>("force sent x"),
    Axis<&Tick::witness, &TickWitness::force_sent_mn, 1>("force sent y"),
    Axis<&Tick::witness, &TickWitness::force_sent_mn, 2>("force sent z"),
    ComputedForce<0>("force computed x"),
    ComputedForce<1>("force computed y"),
    ComputedForce<2>("force computed z"),
    Scalar<&Tick::witness, &TickWitness::flags>("witness flags"),
    Axis<&Tick::input, &TickInput::rest_off_nm, 0>("rest point off x"),
    Axis<&Tick::input, &TickInput::rest_off_nm, 1>("rest point off y"),
    Axis<&Tick::input, &TickInput::rest_off_nm, 2>("rest point off z"),
    Scalar<&Tick::input, &TickInput::share_lost>("share lost"),
}};

// In place; values before the first are 0. Unsigned, so that wrapping is defined.
void Difference(std::span<uint64_t> values) {
  uint64_t before = 0;
  for (uint64_t& v : values) {
    uint64_t here = v;
    v -= before;
    before = here;
  }
}

void Sum(std::span<uint64_t> values) {
  uint64_t sum = 0;
  for (uint64_t& v : values) v = sum += v;
}

// Counted, not written: three of four orders are thrown away.
size_t EncodedSize(std::span<const uint64_t> values) {
  size_t size = 0;
  for (uint64_t v : values) {
    uint64_t zigzag = (v << 1) ^ static_cast<uint64_t>(static_cast<int64_t>(v) >> 63);
    do {
      ++size;
      zigzag >>= 7;
    } while (zigzag != 0);
  }
  return size;
}

void WriteColumn(std::span<uint64_t> values, ByteWriter& out) {
  std::array<Values, kMaxOrder + 1> orders;
  int best = 0;
  size_t best_size = 0;
  for (int order = 0; order <= kMaxOrder; ++order) {
    if (order > 0) Difference(values);
    std::copy(values.begin(), values.end(), orders[static_cast<size_t>(order)].begin());
    size_t size = EncodedSize(values);
    // The lowest of several as short: equal ticks give equal bytes.
    if (order > 0 && size >= best_size) continue;
    best = order;
    best_size = size;
  }
  out.U8(static_cast<uint8_t>(best));
  for (size_t i = 0; i < values.size(); ++i) {
    out.SignedVarint(static_cast<int64_t>(orders[static_cast<size_t>(best)][i]));
  }
}

Status Bad(const Column& column, const std::string& what) {
  return Status(Code::kInvalidInput,
                std::string("chunk payload, column ") + column.name + ": " + what, column.name);
}

Status ReadColumn(const Column& column, ByteReader& in, std::span<Tick> ticks) {
  Values storage;
  std::span<uint64_t> values(storage.data(), ticks.size());
  int order = in.U8();
  if (order > kMaxOrder) {
    return Bad(column, "expected a difference order of 0 to 3, found " + std::to_string(order));
  }
  for (uint64_t& v : values) v = static_cast<uint64_t>(in.SignedVarint());
  if (!in.ok()) return Bad(column, "the payload ends early or holds a number over 64 bits");
  // Wraps as Difference did; whether the outcome fits its field is asked last.
  for (int i = 0; i < order; ++i) Sum(values);
  for (size_t i = 0; i < ticks.size(); ++i) {
    if (!column.set(ticks[i], static_cast<int64_t>(values[i]))) {
      return Bad(column, "value " + std::to_string(static_cast<int64_t>(values[i])) + " of tick " +
                             std::to_string(i) + " does not fit the field");
    }
  }
  return Status::Ok();
}

}  // namespace

Bytes EncodeColumns(std::span<const Tick> ticks) {
  ENAMEL_CHECK(ticks.size() <= kMaxTicksPerChunk);
  ByteWriter out;
  Values storage;
  std::span<uint64_t> values(storage.data(), ticks.size());
  for (const Column& column : kColumns) {
    for (size_t i = 0; i < ticks.size(); ++i)
      values[i] = static_cast<uint64_t>(column.get(ticks[i]));
    WriteColumn(values, out);
  }
  return out.Take();
}

Result<std::vector<Tick>> DecodeColumns(ByteView payload, size_t count) {
  ENAMEL_CHECK(count <= kMaxTicksPerChunk);
  std::vector<Tick> ticks(count);
  ByteReader in(payload);
  for (const Column& column : kColumns) ENAMEL_RETURN_IF_ERROR(ReadColumn(column, in, ticks));
  if (!in.AtEnd()) {
    return Status(Code::kInvalidInput, "chunk payload: " + std::to_string(in.remaining()) +
                                           " bytes left over after the last column");
  }
  return ticks;
}

}  // namespace enamel::trace
